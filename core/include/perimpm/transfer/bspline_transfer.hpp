#pragma once

#include <string>

#include "perimpm/error.hpp"
#include "perimpm/transfer/bspline_gather.hpp"
#include "perimpm/transfer/bspline_scatter.hpp"

/*! Grid transfers with tensor-product B-splines (Stomakhin et al. 2013): parameters, and the choice of the compiled variant. */
namespace perimpm::bspline {

inline constexpr ParamSpec kOrder = {.key = "order",
                                     .kind = ParamKind::integer,
                                     .range = closed(1, 3),
                                     .default_value = 2,
                                     .doc =
                                         "degree of the B-spline: 1 linear, 2 quadratic, 3 cubic; linear "
                                         "splines have no stable step at free surfaces"};
inline constexpr ParamSpec kDivergence = {.key = "stress_divergence",
                                          .kind = ParamKind::choice,
                                          .default_text = "gradient",
                                          .choices = "gradient|mls",
                                          .doc =
                                              "how stress becomes force on the grid: by the spline's gradient, or in "
                                              "one sum with momentum (MLS-MPM, order 2 or 3); "
                                              "forces of bonds are spread as they are, whatever this says"};

/// Largest stable (c + |v|) dt/dx of an isolated particle (Poisson's ratio up to 0.45), the worst case at free
/// surfaces; degree 1 has no positive bound there, its value holds for filled cells.
inline constexpr double kCourant[4] = {0, 0.5, 0.59, 0.70};

/// Chooses the compiled variant for degree, divergence and law; `Scheme` is what the transfer's plugin file writes.
template <class Real, class Scheme>
class Transfer final : public TransferKernel<Real> {
public:
    explicit Transfer(const Params& params)
        : scheme_(params),
          order_(static_cast<std::uint32_t>(params["order"])),
          mls_(params.is("stress_divergence", "mls")) {
        if (mls_ && order_ == 1)
            throw InvalidParameter("stress_divergence",
                                   "\"mls\" needs order 2 or 3: the linear spline's second moment vanishes at nodes");
    }
    TransferNeeds needs() const noexcept override {
        return {.affine = Scheme::affine,
                .increment = Scheme::increment,
                .own_velocity = Scheme::increment,
                .order = order_,
                .courant = kCourant[order_]};
    }
    void scatter(TransferBlock<Real>& b) const override {
        dispatch(static_cast<bool>(b.tau),
                 [&]<int Order, bool mls, bool Local>() { bspline::scatter<Scheme, Real, Order, mls, Local>(b); });
    }
    void gather(TransferBlock<Real>& b) const override {
        dispatch(static_cast<bool>(b.F), [&]<int Order, bool mls, bool Local>() {
            bspline::gather<Scheme, Real, Order, mls, Local>(b, scheme_);
        });
    }

private:
    template <class Body>
    void dispatch(bool local, Body body) const {
        if (!local) return by_order<false, false>(body);
        if (mls_) return by_order<true, true>(body);
        by_order<false, true>(body);
    }
    template <bool mls, bool Local, class Body>
    void by_order(Body body) const {
        if (order_ == 3) return body.template operator()<3, mls, Local>();
        if (order_ == 2) return body.template operator()<2, mls, Local>();
        if constexpr (!mls) body.template operator()<1, mls, Local>();
    }

    Scheme scheme_;
    std::uint32_t order_;
    bool mls_;
};

}  // namespace perimpm::bspline
