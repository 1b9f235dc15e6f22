#pragma once

#include <string>

#include "perimpm/error.hpp"
#include "perimpm/math/bspline.hpp"
#include "perimpm/model/transfer_kernel.hpp"

/*! Scatter and gather with tensor-product B-splines (Stomakhin et al. 2013), shared by all grid transfers.
    Four z-nodes of a tile column, (momentum, mass) each, are sixteen consecutive numbers: one vector. A particle adds
   to column (i, j) of its stencil w_i w_j wz (m v + m C d) + N' S,   S = -dt V tau, which factors into  w_j R_i + w_i
   Y_j  with three vectors R and three Y (four for cubics). Particles come sorted by cell, so the columns stay in
   registers until the stencil moves on. */
namespace perimpm::bspline {

template <class Real>
struct Lanes {
    typedef Real V4 __attribute__((vector_size(4 * sizeof(Real))));
    typedef Real V16 __attribute__((vector_size(16 * sizeof(Real))));
};
template <class Real>
using Vec4 = typename Lanes<Real>::V4;
template <class Real>
using Vec16 = typename Lanes<Real>::V16;

template <class Real>
Vec16<Real> load_column(const Real* from) {
    Vec16<Real> v;
    __builtin_memcpy(&v, from, sizeof v);
    return v;
}
template <class Real>
void store_column(Real* to, const Vec16<Real>& v) {
    __builtin_memcpy(to, &v, sizeof v);
}

/// (a b c d) for each of the four z-nodes.
template <class Real>
Vec16<Real> repeat(Real a, Real b, Real c, Real d) {
    const Vec4<Real> v = {a, b, c, d};
    return __builtin_shufflevector(v, v, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3);
}
/// One number per z-node, repeated for its four values.
template <class Real>
Vec16<Real> spread(const Real z[4]) {
    const Vec4<Real> v = {z[0], z[1], z[2], z[3]};
    return __builtin_shufflevector(v, v, 0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3);
}
/// Sum over the four z-nodes.
template <class Real>
Vec4<Real> sum_nodes(const Vec16<Real>& v) {
    const Vec4<Real> a = __builtin_shufflevector(v, v, 0, 1, 2, 3) + __builtin_shufflevector(v, v, 4, 5, 6, 7);
    const Vec4<Real> b = __builtin_shufflevector(v, v, 8, 9, 10, 11) + __builtin_shufflevector(v, v, 12, 13, 14, 15);
    return a + b;
}

/// Offset of node (base) inside the tile, in numbers.
inline std::int32_t tile_offset(const std::int32_t base[3], const std::int32_t origin[3]) {
    return 4 * (((base[0] - origin[0]) * kTileNodes + (base[1] - origin[1])) * kTileNodes + (base[2] - origin[2]));
}
inline constexpr std::int32_t kRowStride = 4 * kTileNodes, kSlabStride = 4 * kTileNodes * kTileNodes;

template <class Real, int Order>
struct Stencil {
    BSpline<Real, Order> x, y, z;
    std::int32_t offset;

    Stencil(const TransferBlock<Real>& b, std::size_t p, Real inverse_spacing)
        : x(b.x[0][p] * inverse_spacing), y(b.x[1][p] * inverse_spacing), z(b.x[2][p] * inverse_spacing) {
        const std::int32_t base[3] = {x.base, y.base, z.base};
        offset = tile_offset(base, b.origin);
    }
};

/// The columns of one stencil position, kept in registers between particles of the same cell.
template <class Real, int Order>
class Columns {
public:
    explicit Columns(Real* tile) : tile_{tile} {}
    Columns(const Columns&) = delete;
    Columns& operator=(const Columns&) = delete;
    ~Columns() { flush(); }

    void move_to(std::int32_t offset) {
        if (offset == offset_) return;
        flush();
        offset_ = offset;
        for (auto& row : sum_)
            for (auto& column : row) column = Vec16<Real>{};
    }
    Vec16<Real>& operator()(int i, int j) { return sum_[i][j]; }

private:
    void flush() {
        if (offset_ < 0) return;
        for (int i = 0; i <= Order; ++i)
            for (int j = 0; j <= Order; ++j) {
                Real* node = tile_ + offset_ + i * kSlabStride + j * kRowStride;
                store_column<Real>(node, load_column<Real>(node) + sum_[i][j]);
            }
    }

    Real* tile_;
    std::int32_t offset_ = -1;
    Vec16<Real> sum_[Order + 1][Order + 1] = {};
};

/// Adds w_I (q + A d_I) + S grad w_I to every node of the stencil; q = (momentum, mass), A = (A[0] A[1] A[2]) columns
/// in 1/dx, S columns likewise. `Linear` and `Stress` tell which of A and S exist.
template <bool Linear, bool Stress, class Real, int Order>
void add_to_columns(Columns<Real, Order>& columns, const Stencil<Real, Order>& s, const Vec16<Real>& q,
                    const Vec16<Real> A[3], const Vec16<Real> S[3]) {
    const Vec16<Real> wz = spread<Real>(s.z.w);
    Vec16<Real> base = wz * q;
    if constexpr (Linear) base += wz * spread<Real>(s.z.d) * A[2];
    if constexpr (Stress) base += spread<Real>(s.z.dw) * S[2];
    Vec16<Real> Y[Order + 1];
    if constexpr (Linear || Stress)
        for (int j = 0; j <= Order; ++j) {
            Y[j] = Vec16<Real>{};
            if constexpr (Linear) Y[j] += (s.y.w[j] * s.y.d[j]) * (wz * A[1]);
            if constexpr (Stress) Y[j] += s.y.dw[j] * (wz * S[1]);
        }
    for (int i = 0; i <= Order; ++i) {
        Vec16<Real> R = s.x.w[i] * base;
        if constexpr (Linear) R += (s.x.w[i] * s.x.d[i]) * (wz * A[0]);
        if constexpr (Stress) R += s.x.dw[i] * (wz * S[0]);
        for (int j = 0; j <= Order; ++j) {
            columns(i, j) += s.y.w[j] * R;
            if constexpr (Linear || Stress) columns(i, j) += s.x.w[i] * Y[j];
        }
    }
}

enum class Divergence { gradient, mls };

/// What a particle hands to the grid, by transfer: Scheme::affine adds m C d to its momentum, Scheme::increment keeps
/// impulses apart so that the grid knows the velocity before forces.
template <class Scheme, class Real, int Order, Divergence divergence, bool Local>
void scatter(TransferBlock<Real>& b) {
    constexpr bool mls = Local && divergence == Divergence::mls, stress = Local && !mls;
    constexpr bool together = !Scheme::increment;
    const Real inverse_spacing = 1 / b.spacing;
    Columns<Real, Order> momentum(b.tile);
    Columns<Real, Order> impulse(Scheme::increment ? b.increment : b.tile);
    for (std::size_t p = 0; p < b.size; ++p) {
        const Stencil<Real, Order> s(b, p, inverse_spacing);
        const Real m = b.mass[p];
        Real q[3] = {m * b.v[0][p], m * b.v[1][p], m * b.v[2][p]};
        Vec16<Real> A[3] = {}, S[3] = {}, I[3] = {};
        if constexpr (Scheme::affine) {
            const Real a = m * b.spacing;
            for (int j = 0; j < 3; ++j) A[j] = repeat<Real>(a * b.C[j][p], a * b.C[3 + j][p], a * b.C[6 + j][p], 0);
        }
        if constexpr (Local) {
            const Real scale = -b.dt * b.volume[p] * inverse_spacing * (mls ? Real(1 / kSecondMoment<Order>) : Real(1));
            const Real xx = scale * b.tau[0][p], xy = scale * b.tau[1][p], xz = scale * b.tau[2][p];
            const Real yy = scale * b.tau[3][p], yz = scale * b.tau[4][p], zz = scale * b.tau[5][p];
            Vec16<Real>* to = mls ? (together ? A : I) : S;
            to[0] += repeat<Real>(xx, xy, xz, 0);
            to[1] += repeat<Real>(xy, yy, yz, 0);
            to[2] += repeat<Real>(xz, yz, zz, 0);
        }
        Real f[3] = {};
        if constexpr (!Local)
            for (int c = 0; c < 3; ++c) f[c] = b.dt * b.force[c][p];
        momentum.move_to(s.offset);
        if constexpr (together) {
            const auto total = repeat<Real>(q[0] + f[0], q[1] + f[1], q[2] + f[2], m);
            add_to_columns<Scheme::affine || mls, stress, Real>(momentum, s, total, A, S);
        } else {
            impulse.move_to(s.offset);
            add_to_columns<Scheme::affine, false, Real>(momentum, s, repeat<Real>(q[0], q[1], q[2], m), A, S);
            add_to_columns<mls, stress, Real>(impulse, s, repeat<Real>(f[0], f[1], f[2], 0), I, S);
        }
    }
}

/// What the grid hands back at one particle: velocity, its gradient and its first moments, as far as asked for.
template <class Real>
struct Sample {
    Vec4<Real> v;            ///< sum_I w v_I
    Vec4<Real> gradient[3];  ///< dx sum_I v_I dw_I/dx_j
    Vec4<Real> moment[3];    ///< sum_I w v_I d_j, d in dx
};

template <bool Gradient, bool Moment, class Real, int Order>
Sample<Real> sample(const Real* tile, const Stencil<Real, Order>& s) {
    Vec16<Real> value{}, gx{}, gy{}, mx{}, my{};
    for (int i = 0; i <= Order; ++i) {
        Vec16<Real> c{}, cg{}, cm{};
        for (int j = 0; j <= Order; ++j) {
            const Vec16<Real> column = load_column<Real>(tile + s.offset + i * kSlabStride + j * kRowStride);
            c += s.y.w[j] * column;
            if constexpr (Gradient) cg += s.y.dw[j] * column;
            if constexpr (Moment) cm += (s.y.w[j] * s.y.d[j]) * column;
        }
        value += s.x.w[i] * c;
        if constexpr (Gradient) gx += s.x.dw[i] * c, gy += s.x.w[i] * cg;
        if constexpr (Moment) mx += (s.x.w[i] * s.x.d[i]) * c, my += s.x.w[i] * cm;
    }
    const Vec16<Real> wz = spread<Real>(s.z.w);
    Sample<Real> r;
    const Vec16<Real> weighted = wz * value;
    r.v = sum_nodes<Real>(weighted);
    if constexpr (Gradient) {
        r.gradient[0] = sum_nodes<Real>(wz * gx);
        r.gradient[1] = sum_nodes<Real>(wz * gy);
        r.gradient[2] = sum_nodes<Real>(spread<Real>(s.z.dw) * value);
    }
    if constexpr (Moment) {
        r.moment[0] = sum_nodes<Real>(wz * mx);
        r.moment[1] = sum_nodes<Real>(wz * my);
        r.moment[2] = sum_nodes<Real>(weighted * spread<Real>(s.z.d));
    }
    return r;
}

/// F <- (I + dt grad v) F.
template <class Real>
void update_deformation(const Field<Real>& F, std::size_t p, const Real dt_gradient[9]) {
    for (int j = 0; j < 3; ++j) {
        const Real f[3] = {F[j][p], F[3 + j][p], F[6 + j][p]};
        for (int i = 0; i < 3; ++i)
            F[3 * i + j][p] =
                f[i] + dt_gradient[3 * i] * f[0] + dt_gradient[3 * i + 1] * f[1] + dt_gradient[3 * i + 2] * f[2];
    }
}

/// Scheme::velocity(b, p, c, now, before) gives component c of the particle's new velocity.
template <class Scheme, class Real, int Order, Divergence divergence, bool Local>
void gather(TransferBlock<Real>& b, const Scheme& scheme) {
    constexpr bool mls = divergence == Divergence::mls;
    constexpr bool moment = Order > 1 && (Scheme::affine || (Local && mls));
    constexpr bool gradient = (Local && !mls) || (Scheme::affine && Order == 1);
    const Real inverse_spacing = 1 / b.spacing;
    const Real moment_scale = inverse_spacing * Real(1 / kSecondMoment<Order>);
    Real fastest = 0, total = 0;
    for (std::size_t p = 0; p < b.size; ++p) {
        const Stencil<Real, Order> s(b, p, inverse_spacing);
        const Sample<Real> now = sample<gradient, moment, Real>(b.tile, s);
        Vec4<Real> before{};
        if constexpr (Scheme::increment) before = sample<false, false, Real>(b.increment, s).v;
        Real speed2 = 0;
        for (int c = 0; c < 3; ++c) {
            b.v[c][p] = scheme.template velocity<Real>(b.v[c][p], now.v[c], before[c]);
            b.x[c][p] += b.dt * now.v[c];
            speed2 += now.v[c] * now.v[c];
        }
        fastest = speed2 > fastest ? speed2 : fastest;
        total += speed2;
        if constexpr (gradient || moment)
            for (int i = 0; i < 3; ++i)
                for (int j = 0; j < 3; ++j) {
                    if constexpr (Scheme::affine)
                        b.C[3 * i + j][p] =
                            Order > 1 ? moment_scale * now.moment[j][i] : inverse_spacing * now.gradient[j][i];
                }
        if constexpr (Local) {
            Real step[9];
            for (int i = 0; i < 3; ++i)
                for (int j = 0; j < 3; ++j)
                    step[3 * i + j] =
                        b.dt * (mls ? moment_scale * now.moment[j][i] : inverse_spacing * now.gradient[j][i]);
            update_deformation(b.F, p, step);
        }
    }
    b.fastest2 = fastest;
    b.sum2 = total;
}

inline constexpr ParamSpec kOrder = {.key = "order",
                                     .kind = ParamKind::integer,
                                     .range = closed(1, 3),
                                     .default_value = 2,
                                     .doc = "degree of the B-spline: 1 linear, 2 quadratic, 3 cubic"};
inline constexpr ParamSpec kDivergence = {
    .key = "stress_divergence",
    .kind = ParamKind::choice,
    .default_text = "gradient",
    .choices = "gradient|mls",
    .doc = "how stress becomes force on the grid: by the spline's gradient, or in one sum with momentum (MLS-MPM)"};

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
        return {.affine = Scheme::affine, .increment = Scheme::increment, .order = order_, .courant = kCourant[order_]};
    }
    void scatter(TransferBlock<Real>& b) const override {
        dispatch(b, [&]<int Order, Divergence divergence, bool Local>() {
            bspline::scatter<Scheme, Real, Order, divergence, Local>(b);
        });
    }
    void gather(TransferBlock<Real>& b) const override {
        dispatch(b, [&]<int Order, Divergence divergence, bool Local>() {
            bspline::gather<Scheme, Real, Order, divergence, Local>(b, scheme_);
        });
    }

private:
    template <class Body>
    void dispatch(const TransferBlock<Real>& b, Body body) const {
        if (!b.F) return by_order<Divergence::gradient, false>(body);
        if (mls_) return by_order<Divergence::mls, true>(body);
        by_order<Divergence::gradient, true>(body);
    }
    template <Divergence divergence, bool Local, class Body>
    void by_order(Body body) const {
        if (order_ == 3) return body.template operator()<3, divergence, Local>();
        if (order_ == 2) return body.template operator()<2, divergence, Local>();
        if constexpr (divergence == Divergence::gradient) body.template operator()<1, divergence, Local>();
    }

    Scheme scheme_;
    std::uint32_t order_;
    bool mls_;
};

}  // namespace perimpm::bspline
