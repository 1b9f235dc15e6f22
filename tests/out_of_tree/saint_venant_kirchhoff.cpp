/*! Saint Venant-Kirchhoff elasticity: Hooke's law for the Green-Lagrange strain. For moderate strains; under strong
    compression it softens and gives way. Holzapfel 2000, Nonlinear Solid Mechanics, section 6.5.
      (1) E = (F^T F - I)/2                        Green-Lagrange strain [1]
      (2) W = lambda/2 tr(E)^2 + mu E : E          energy density [Pa]
      (3) S = lambda tr(E) I + 2 mu E              second Piola-Kirchhoff stress [Pa]
      (4) tau = F S F^T                            Kirchhoff stress [Pa]
      (5) rho c^2 = s^4 (lambda + 2 mu) + s^2 S    wave along a principal stretch s with stress S */
#include <algorithm>
#include <cmath>

#include "perimpm/math/elasticity.hpp"
#include "perimpm/math/mat3.hpp"
#include "perimpm/plugin/plugin.hpp"

namespace {
using namespace perimpm;

constexpr ParamSpec kParams[] = {
    {.key = "youngs_modulus", .unit = "Pa", .range = above(0), .doc = "Young's modulus at small strain"},
    {.key = "poisson_ratio",
     .range = {.low = 0, .high = 0.5, .low_open = false},
     .default_value = 0.25,
     .doc = "Poisson's ratio at small strain"},
};

template <class Real>
class SaintVenantKirchhoff final : public ConstitutiveLaw<Real> {
public:
    explicit SaintVenantKirchhoff(const Params& p)
        : youngs_modulus_{p["youngs_modulus"]},
          poisson_ratio_{p["poisson_ratio"]},
          density_{p.context().density},
          lame_{static_cast<Real>(youngs_modulus_), poisson_ratio_} {}
    LawNeeds needs() const noexcept override {
        return {.deformation_gradient = true, .moduli = {youngs_modulus_, poisson_ratio_}};
    }

    void evaluate(Block<Real>& b, Real) const override {
        for (std::size_t i = 0; i < b.size; ++i) {
            const Mat3<Real> F = load_F(b, i);
            const Mat3<Real> E = strain(F);
            const Real pressure = lame_.lambda * (E(0, 0) + E(1, 1) + E(2, 2));
            Mat3<Real> S;
            for (int c = 0; c < 9; ++c) S.m[c] = 2 * lame_.mu * E.m[c] + (c % 4 == 0 ? pressure : 0);  // (3)
            const Mat3<Real> tau = F * S * transpose(F);                                               // (4)
            int component = 0;
            for (int row = 0; row < 3; ++row)
                for (int column = row; column < 3; ++column) b.tau[component++][i] = tau(row, column);
        }
    }

    double max_wave_speed(const Block<Real>& b) const override {
        Real modulus = 0;
        for (std::size_t i = 0; i < b.size; ++i) {
            const Mat3<Real> E = strain(load_F(b, i));
            Real stretch2 = 0;  // a row sum of F^T F bounds its largest eigenvalue
            for (int r = 0; r < 3; ++r)
                stretch2 = std::max(
                    stretch2, 1 + 2 * E(r, r) + 2 * std::abs(E(r, (r + 1) % 3)) + 2 * std::abs(E(r, (r + 2) % 3)));
            const Real stress =
                std::max(Real(0), (3 * lame_.lambda + 2 * lame_.mu) * (stretch2 - 1) / 2);  // if all three were as long
            modulus = std::max(modulus, stretch2 * (stretch2 * (lame_.lambda + 2 * lame_.mu) + stress));  // (5)
        }
        return std::sqrt(static_cast<double>(modulus) / density_);
    }

    double energy(const Block<Real>& b) const override {
        double total = 0;
        for (std::size_t i = 0; i < b.size; ++i) {
            const Mat3<Real> E = strain(load_F(b, i));
            const Real trace = E(0, 0) + E(1, 1) + E(2, 2);
            Real squares = 0;
            for (const Real e : E.m) squares += e * e;
            total += static_cast<double>(b.volume[i] * (lame_.lambda / 2 * trace * trace + lame_.mu * squares));  // (2)
        }
        return total;
    }

private:
    static Mat3<Real> load_F(const Block<Real>& b, std::size_t i) {
        Mat3<Real> F;
        for (std::size_t c = 0; c < 9; ++c) F.m[c] = b.F[c][i];
        return F;
    }
    static Mat3<Real> strain(const Mat3<Real>& F) {  // (1)
        Mat3<Real> E = transpose(F) * F;
        for (int c = 0; c < 9; ++c) E.m[c] = (E.m[c] - (c % 4 == 0 ? 1 : 0)) / 2;
        return E;
    }

    double youngs_modulus_, poisson_ratio_, density_;
    Lame<Real> lame_;
};
}  // namespace

PERIMPM_PLUGIN(ConstitutiveLaw, SaintVenantKirchhoff, kParams,
               "Saint Venant-Kirchhoff elasticity, for moderate strains")
