// REFERENCES.md C6: a perfectly plastic block in simple shear, x = X + gamma Y e_x, up to gamma = 5; E = 200 GPa, yield
// stress Y = 250 MPa. Finite-strain J2 saturates at
//   (1) tau = Y/sqrt(3) = 144.34 MPa
// Bond laws: every particle of a cube is placed, and the mean stress is
//   (2) tau = -(1/V) sum_p f_p (x) x_p,  its xy component
// divided by what (2) gives for a small elastic shear over mu gamma, which takes the surface out.
#include <fmt/format.h>

#include <cstdlib>
#include <numbers>

#include "support/catch.hpp"
#include "support/model.hpp"
#include "support/particles.hpp"

using namespace perimpm;
using Eigen::Matrix3d;

namespace {

constexpr double kYoung = 200e9, kYield = 250e6, kSpacing = 0.01, kVolume = kSpacing * kSpacing * kSpacing;
const double kSaturation = kYield / std::numbers::sqrt3;  // (1)

ModelPtr<ConstitutiveLaw, double> law_of(const std::string& name, double poisson, const std::string& more = "") {
    return make<ConstitutiveLaw, double>(
        name, fmt::format("youngs_modulus = {}\nyield_stress = {}\npoisson_ratio = {}\n{}", kYoung, kYield, poisson, more),
        {.density = 8000, .particle_spacing = kSpacing, .grid_spacing = 2 * kSpacing});
}
Matrix3d sheared(double gamma) {
    Matrix3d F = Matrix3d::Identity();
    F(0, 1) = gamma;
    return F;
}

/// A local law, in steps of `step`: the last elastic F with the increment in front.
class Point {
public:
    explicit Point(const ConstitutiveLaw<double>& law) : point_(law, {Vec3::Zero()}, kVolume) {}
    void deform(const Matrix3d& increment) {
        Matrix3d F;
        for (int c = 0; c < 9; ++c) F(c / 3, c % 3) = point_.block().F[c][0];
        point_.set_F(0, increment * F);
        point_.evaluate();
    }
    Matrix3d stress() const { return point_.tau(0); }
    double plastic_strain() { return point_.block().particle_state[0][0][0]; }

private:
    Particles<double> point_;
};

/// A cube of a bond law.
class Cube {
public:
    explicit Cube(const ConstitutiveLaw<double>& law) : points_(law, lattice(8, kSpacing), kVolume) {
        constexpr double small = 1e-6;
        factor_ = kYoung / 2 / (1 + law.needs().moduli.poisson_ratio) * small / stress(sheared(small));
    }
    /// (2), of the x and y components [Pa].
    double stress(const Matrix3d& F) {
        points_.deform(F);
        points_.evaluate();
        double sum = 0;
        for (std::size_t p = 0; p < points_.size(); ++p) sum -= points_.force(p)[0] * (F * points_.reference()[p])[1];
        return factor_ * sum / (static_cast<double>(points_.size()) * kVolume);
    }
    double yielded(const ConstitutiveLaw<double>& law) {
        const LawNeeds needs = law.needs();
        double sum = 0;
        for (std::uint32_t k = 0; k < needs.bond_state.size; ++k)
            for (std::size_t s = 0; std::string(needs.bond_state.data[k].name) == "plastic_strain" && s < points_.bonds().size(); ++s)
                sum += std::abs(points_.block().bond_state[k][s]);
        return sum;
    }

private:
    Particles<double> points_;
    double factor_ = 1;
};

struct Case {
    const char *name, *law, *more;
    double poisson;
};
constexpr Case kBondLaws[] = {{"deviatoric_plastic bond", "deviatoric_plastic", "", 0.25},
                              {"deviatoric_plastic family", "deviatoric_plastic", "yield = \"family\"", 0.25},
                              {"pd_lps bond", "pd_lps", "yield = \"bond\"", 0.3},
                              {"pd_lps family", "pd_lps", "", 0.3}};

}  // namespace

TEST_CASE("simple shear: finite-strain J2 saturates and stays", "[verification]") {
    const auto law = law_of("von_mises", 0.3);
    Point point(*law);
    const Matrix3d increment = sheared(1e-3);
    for (int n = 1; n <= 5000; ++n) {
        point.deform(increment);
        if (n >= 20) CHECK_THAT(point.stress()(0, 1), WithinRel(kSaturation, 1e-3));
    }
    CHECK_THAT(point.stress()(0, 1), WithinRel(kSaturation, 1e-5));
    CHECK_THAT(point.plastic_strain(), WithinRel(5 / std::numbers::sqrt3, 1e-3));
}

TEST_CASE("simple shear: a rigid turn keeps the turned stress and yields nothing", "[verification]") {
    const int turns = 360;
    const Vec3 axis(1, -2, 3);
    const auto local = law_of("von_mises", 0.3);
    Point point(*local);
    for (int n = 0; n < 20; ++n) point.deform(sheared(1e-3));
    const Matrix3d before = point.stress();
    const double strain = point.plastic_strain();
    for (int n = 0; n < turns; ++n) point.deform(rotation(2 * std::numbers::pi / turns, axis));
    CHECK((point.stress() - before).norm() <= 1e-6 * before.norm());
    CHECK(point.plastic_strain() - strain <= 1e-9 * strain);
    for (const Case& c : kBondLaws) {
        CAPTURE(c.name);
        const auto law = law_of(c.law, c.poisson, c.more);
        Cube cube(*law);
        for (int n = 1; n <= 20; ++n) cube.stress(sheared(1e-3 * n));
        const double stress = cube.stress(sheared(0.02)), yielded = cube.yielded(*law);
        for (int n = 1; n <= 36; ++n) cube.stress(rotation(2 * std::numbers::pi * n / 36, axis) * sheared(0.02));
        CHECK_THAT(cube.stress(sheared(0.02)), WithinRel(stress, 1e-6));
        CHECK_THAT(cube.yielded(*law), WithinRel(yielded, 1e-9));
    }
}

/// Every row of tests/bench/studies/shear.py, which runs this.
TEST_CASE("simple shear: table", "[.shear][verification]") {
    if (!std::getenv("PERIMPM_TABLE")) return;  // CTest runs hidden cases, too
    fmt::print("row,law,gamma,stress\n");
    constexpr int steps = 2500;
    const auto print_row = [](const char* name, int n, double gamma, double stress) {
        if (n % 50 == 0 || (n <= 10)) fmt::print("row,{},{:.4g},{:.5f}\n", name, gamma, stress / kSaturation);
    };
    const auto local = law_of("von_mises", 0.3);
    Point point(*local);
    for (int n = 1; n <= steps; ++n) {
        point.deform(sheared(5.0 / steps));
        print_row("von_mises", n, 5.0 * n / steps, point.stress()(0, 1));
    }
    for (const Case& c : kBondLaws) {
        const auto law = law_of(c.law, c.poisson, c.more);
        Cube cube(*law);
        for (int n = 1; n <= steps; ++n) print_row(c.name, n, 5.0 * n / steps, cube.stress(sheared(5.0 * n / steps)));
    }
}
