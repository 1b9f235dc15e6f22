// REFERENCES.md C1 (paper's bond law); METHOD.md section 4 and its Table 1.
#include <fmt/format.h>

#include "support/catch.hpp"
#include "support/message.hpp"
#include "support/model.hpp"
#include "support/particles.hpp"

using namespace perimpm;

namespace {

// At 1 m the psi of Table 1 are strains of 1e-4, far from rounding.
constexpr double kSpacing = 1, kVolume = kSpacing * kSpacing * kSpacing;
constexpr ModelContext kContext{.density = 1000, .particle_spacing = kSpacing, .grid_spacing = 2 * kSpacing};

ModelPtr<ConstitutiveLaw, double> plastic(const std::string& table) {
    return make<ConstitutiveLaw, double>("deviatoric_plastic", table, kContext);
}
std::string paper(double mu, double lambda) {
    return fmt::format(
        "calibration = \"paper\"\nsurface = \"family\"\ninfluence = \"constant\"\nmu = {:.17g}\nlambda = {:.17g}\n", mu,
        lambda);
}
double* bond_field(Particles<double>& particles, const ConstitutiveLaw<double>& law, const std::string& name) {
    const LawNeeds needs = law.needs();
    for (std::uint32_t k = 0; k < needs.bond_state.size; ++k)
        if (needs.bond_state.data[k].name == name) return particles.block().bond_state[k];
    return nullptr;
}
/// A shear and stretch that every law of the table yields under, or not, by its size.
void strain(Particles<double>& particles, double size) {
    particles.move([&](const Vec3& X) -> Vec3 { return X + size * Vec3(X[0] + 0.5 * X[1], -0.4 * X[1], 0.2 * X[2]); });
}

/// (8), (10) by the book for one particle of a family with constant influence, w = 5 / (N V).
struct ByHand {
    std::vector<double> deviatoric, gain;  ///< e_dev and (2 mu + lambda) w/|X| of the bonds

    ByHand(Particles<double>& particles, std::size_t p, double modulus) {
        const Bonds& bonds = particles.bonds();
        const double w = 5 / ((bonds.row[p + 1] - bonds.row[p]) * kVolume);
        const auto y = [&](std::size_t q) {
            const auto x = particles.block().x;
            return Vec3(x[0][q], x[1][q], x[2][q]);
        };
        double m = 0, sum = 0;
        for (std::uint32_t s = bonds.row[p]; s < bonds.row[p + 1]; ++s) {
            const std::size_t q = bonds.neighbour[s];
            const double X = (particles.reference()[q] - particles.reference()[p]).norm();
            const double e = (y(q) - y(p)).norm() - X;
            m += X * X, sum += X * e;
            deviatoric.push_back(e / X);
            gain.push_back(modulus * w / X);
        }
        for (double& e : deviatoric) e -= sum / m;  // theta/3
    }
};

struct Set {
    const char* name;
    double lambda, mu, psi;
};
constexpr Set kTable1[] = {{"elastic board", 3e6, 1.5e5, 1e25}, {"plastic board", 5e6, 1.5e5, 1000},
                           {"plastic bunny", 1e6, 3e5, 300},    {"broken board", 1e6, 5e4, 500},
                           {"cloth", 1e6, 1e6, 1e25},           {"beam", 500, 500, 1e25}};

}  // namespace

TEST_CASE("deviatoric_plastic: the consistent return lands on the yield surface", "[constitutive]") {
    for (const Set& set : kTable1)
        for (const bool family : {false, true}) {
            CAPTURE(set.name, family);
            const double modulus = 2 * set.mu + set.lambda;
            const auto law = plastic(paper(set.mu, set.lambda) + fmt::format("yield_psi = {:.17g}\n", set.psi) +
                                     (family ? "yield = \"family\"\n" : ""));
            Particles<double> particles(*law, lattice(5, kSpacing), kVolume);
            strain(particles, 0.01);
            particles.evaluate();
            const double* strain_p = bond_field(particles, *law, "plastic_strain");
            for (const std::size_t p : {std::size_t{0}, middle(5)}) {
                const ByHand hand(particles, p, modulus);
                double together = 0;
                std::size_t yielded = 0;
                for (std::size_t k = 0; k < hand.gain.size(); ++k) {
                    const double e_p = strain_p[particles.bonds().row[p] + k];
                    const double E = hand.gain[k] * (hand.deviatoric[k] - e_p);
                    together += E * E * kVolume;
                    yielded += e_p != 0;
                    if (family) continue;
                    if (e_p != 0) CHECK_THAT(std::abs(E) / std::sqrt(2 * set.psi), WithinAbs(1, 1e-11));
                    CHECK(E * E / 2 <= set.psi * (1 + 1e-11));
                }
                CHECK((yielded > 0) == (set.psi < 1e20));
                if (family && yielded > 0) CHECK_THAT(together / (2 * set.psi), WithinRel(1.0, 1e-11));
            }
            // A second update with the same positions changes nothing.
            const std::vector<double> before(strain_p, strain_p + particles.bonds().size());
            particles.evaluate();
            for (std::size_t s = 0; s < before.size(); ++s)
                CHECK(std::abs(strain_p[s] - before[s]) <= 1e-12 * std::abs(before[s]));
        }
}

TEST_CASE("deviatoric_plastic: with a yield stress the return is exact to rounding", "[constitutive]") {
    // Yield strain sigma_y/(2 mu + lambda) of every bond; with hardening H it grows by H/(2 mu + lambda) of what yielded.
    for (const Set& set : kTable1)
        for (const double hardening : {0.0, 0.5}) {
            CAPTURE(set.name, hardening);
            const double modulus = 2 * set.mu + set.lambda;
            const auto law =
                plastic(paper(set.mu, set.lambda) + fmt::format("yield_stress = {:.17g}\n", 0.002 * modulus) +
                        fmt::format("hardening_modulus = {:.17g}\n", hardening * modulus));
            Particles<double> particles(*law, lattice(5, kSpacing), kVolume);
            strain(particles, 0.01);
            particles.evaluate();
            const double* strain_p = bond_field(particles, *law, "plastic_strain");
            const std::size_t p = middle(5);
            const ByHand hand(particles, p, modulus);
            std::size_t yielded = 0;
            for (std::size_t k = 0; k < hand.gain.size(); ++k) {
                const double e_p = strain_p[particles.bonds().row[p] + k];
                const double limit = 0.002 + hardening * std::abs(e_p), left = std::abs(hand.deviatoric[k] - e_p);
                CHECK(left <= limit + 1e-14);
                if (e_p != 0) CHECK_THAT(left, WithinAbs(limit, 1e-14));
                yielded += e_p != 0;
            }
            CHECK(yielded > 0);
        }
}

TEST_CASE("deviatoric_plastic: the printed return multiplies the excess by -2 mu/lambda", "[constitutive]") {
    // After one return |E| - s = (1 - (2 mu + lambda)/lambda) times what it was.
    for (const Set& set : kTable1) {
        CAPTURE(set.name);
        const double modulus = 2 * set.mu + set.lambda, limit = 0.002;
        const auto law = plastic(paper(set.mu, set.lambda) + fmt::format("yield_stress = {:.17g}\n", limit * modulus) +
                                 "return_mapping = \"paper\"\n");
        Particles<double> particles(*law, lattice(5, kSpacing), kVolume);
        strain(particles, 0.01);
        particles.evaluate();
        const double* strain_p = bond_field(particles, *law, "plastic_strain");
        const std::size_t p = middle(5);
        const ByHand hand(particles, p, modulus);
        for (std::size_t k = 0; k < hand.gain.size(); ++k) {
            const double e = hand.deviatoric[k], before = std::abs(e) - limit;
            if (before <= 0) continue;
            const double after = (e - strain_p[particles.bonds().row[p] + k]) * (e > 0 ? 1 : -1) - limit;
            CHECK_THAT(after, WithinAbs(-2 * set.mu / set.lambda * before, 1e-14));
        }
    }
}

TEST_CASE("deviatoric_plastic: pd_elastic bit for bit without yield and while nothing has yielded", "[constitutive]") {
    for (const char* yield : {"", "yield_stress = 1e9\n", "yield_psi = 1e35\nyield = \"family\"\n"})
        for (const char* more : {"", "bending_ratio = 0.0\n", "influence = \"constant\"\n", "surface = \"family\"\n",
                                 "surface = \"ghost\"\n", "bending_ratio = 0.0\nsurface = \"family\"\n"}) {
            CAPTURE(yield, more);
            const std::string table = std::string("youngs_modulus = 1e6\n") + more;
            const auto elastic = make<ConstitutiveLaw, double>("pd_elastic", table, kContext);
            const auto law = plastic(table + yield);
            Particles<double> a(*elastic, lattice(6, kSpacing), kVolume), b(*law, lattice(6, kSpacing), kVolume);
            std::mt19937 random(3);
            std::uniform_real_distribution<double> shift(-0.1 * kSpacing, 0.1 * kSpacing);
            for (std::size_t p = 0; p < a.size(); ++p) {
                const Vec3 y = a.reference()[p] + Vec3(shift(random), shift(random), shift(random));
                a.place(p, y), b.place(p, y);
            }
            a.evaluate(), b.evaluate();
            for (std::size_t p = 0; p < a.size(); ++p) CHECK(a.force(p) == b.force(p));
            CHECK((bond_field(b, *law, "plastic_strain") == nullptr) == (*yield == 0));
        }
}

TEST_CASE("deviatoric_plastic: yielded bonds balance and feel the permanent strain of both ends", "[constitutive]") {
    for (const char* more : {"", "formulation = \"paper\"\n", "bending_ratio = 0.0\n", "yield = \"family\"\n"}) {
        CAPTURE(more);
        const auto law = plastic(std::string("youngs_modulus = 1e6\nyield_stress = 1e3\n") + more);
        Particles<double> particles(*law, lattice(5, kSpacing), kVolume);
        std::mt19937 random(3);
        std::uniform_real_distribution<double> shift(-0.1 * kSpacing, 0.1 * kSpacing);
        particles.move([&](const Vec3& X) -> Vec3 { return X + Vec3(shift(random), shift(random), shift(random)); });
        particles.evaluate();
        Vec3 sum = Vec3::Zero();
        double scale = 0;
        for (std::size_t p = 0; p < particles.size(); ++p)
            sum += particles.force(p), scale += particles.force(p).norm();
        REQUIRE(scale > 0);
        CHECK(sum.norm() <= 1e-13 * scale);
        // back at the start, what yielded pushes
        particles.move([](const Vec3& X) { return X; });
        particles.evaluate();
        CHECK(particles.largest_force() > 1e-3 * scale / static_cast<double>(particles.size()));
    }
}

TEST_CASE("deviatoric_plastic: parameters that contradict are refused by name", "[constitutive]") {
    const auto refused = [](const std::string& more) {
        try {
            plastic("youngs_modulus = 1e6\n" + more);
        } catch (const InvalidParameter& e) {
            return e.key();
        }
        return std::string();
    };
    CHECK(refused("yield_stress = 1e3\nyield_psi = 1.0\n") == "yield_psi");
    CHECK(refused("hardening_modulus = 1.0\n") == "hardening_modulus");
    CHECK(refused("yield = \"family\"\n") == "yield");
    CHECK(refused("yield_stress = 1.0\npoisson_ratio = 0.3\n") == "poisson_ratio");
}
