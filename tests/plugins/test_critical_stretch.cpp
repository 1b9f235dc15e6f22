// REFERENCES.md D6: share of bonds broken by a homogeneous strain of a full family. D1: energy of a plane that opens.
#include <fmt/format.h>

#include <numbers>

#include "support/catch.hpp"
#include "support/message.hpp"
#include "support/model.hpp"
#include "support/particles.hpp"

using namespace perimpm;
using Eigen::Matrix3d;

namespace {

constexpr double kLimit = 1e-6;  // s0: small, so that the stretch is the linearised one

ModelPtr<ConstitutiveLaw, double> springs(double horizon) {
    return make<ConstitutiveLaw, double>("pd_bond", "youngs_modulus = 1\nhorizon = " + std::to_string(horizon),
                                         {.density = 1, .particle_spacing = 1, .grid_spacing = 0});
}

/// Bonds of particle p that the criterion finds.
std::vector<BondCandidate> screen(Particles<double>& particles, std::size_t p, double limit = kLimit) {
    const auto criterion =
        make<FractureCriterion, double>("critical_stretch", "critical_stretch = " + fmt::format("{}", limit));
    std::vector<BondCandidate> room(particles.bonds().size());
    CandidateList found{room.data(), 0};
    criterion->screen(particles.block(p, 1), found);
    room.resize(found.size);
    return room;
}

Matrix3d uniaxial(double strain) { return Vec3(1 + strain, 1, 1).asDiagonal(); }

}  // namespace

TEST_CASE("critical_stretch: uniaxial strain breaks the published share of a lattice's bonds", "[fracture]") {
    struct Row {
        double horizon;
        std::size_t bonds;
        double share[5];
    };
    const double strains[] = {1.05, 1.6, 2.2, 3.5, 4.5};  // in s0
    for (const Row& row : {Row{3.0, 122, {0.0492, 0.1803, 0.3115, 0.5082, 0.5082}},
                           {3.015, 122, {0.0492, 0.1803, 0.3115, 0.5082, 0.5082}},
                           {4.0, 256, {0.0312, 0.2500, 0.3125, 0.5312, 0.5312}},
                           {6.0, 924, {0.0216, 0.2121, 0.3333, 0.4805, 0.5411}}}) {
        const auto law = springs(row.horizon);
        const int count = 2 * static_cast<int>(row.horizon) + 1;
        Particles<double> particles(*law, lattice(count, 1.0), 1.0);
        const std::size_t p = middle(count), size = particles.bonds().row[p + 1] - particles.bonds().row[p];
        REQUIRE(size == row.bonds);
        for (std::size_t k = 0; k < std::size(strains); ++k) {
            CAPTURE(row.horizon, strains[k]);
            particles.deform(uniaxial(strains[k] * kLimit));
            CHECK_THAT(static_cast<double>(screen(particles, p).size()) / static_cast<double>(size),
                       WithinAbs(row.share[k], 5.1e-5));
        }
    }
}

TEST_CASE("critical_stretch: below s0 nothing breaks, isotropic strain breaks everything together", "[fracture]") {
    const auto law = springs(3.015);
    Particles<double> particles(*law, lattice(7, 1.0), 1.0);
    const std::size_t p = middle(7);
    particles.deform(uniaxial(0.99 * kLimit));
    CHECK(screen(particles, p).empty());
    particles.deform((1 + 0.999 * kLimit) * Matrix3d::Identity());
    CHECK(screen(particles, p).empty());
    particles.deform((1 + 1.001 * kLimit) * Matrix3d::Identity());
    CHECK(screen(particles, p).size() == 122);
}

TEST_CASE("critical_stretch: compression breaks nothing", "[fracture]") {
    const auto law = springs(3.015);
    Particles<double> particles(*law, lattice(7, 1.0), 1.0);
    for (const double strain : {-1e-5, -0.1, -0.9}) {
        particles.deform(uniaxial(strain));
        for (std::size_t p = 0; p < particles.size(); ++p) CHECK(screen(particles, p).empty());
    }
}

TEST_CASE("critical_stretch: candidates are the particle's own long bonds, broken ones are not found again",
          "[fracture]") {
    const auto law = springs(3.015);
    Particles<double> particles(*law, lattice(7, 1.0), 1.0);
    const std::size_t p = middle(7);
    particles.deform(uniaxial(0.5));
    const auto found = screen(particles, p, 0.3);
    REQUIRE_FALSE(found.empty());
    for (const BondCandidate& c : found) {
        CHECK(c.particle == p);
        const Vec3 X = particles.reference()[particles.bonds().neighbour[c.bond]] - particles.reference()[p];
        CHECK((uniaxial(0.5) * X).norm() > 1.3 * X.norm());
    }
    particles.bonds().break_direction(static_cast<std::uint32_t>(p), found[0].bond);
    const auto again = screen(particles, p, 0.3);
    CHECK(again.size() == found.size() - 1);
    for (const BondCandidate& c : again) CHECK(c.bond != found[0].bond);
}

TEST_CASE("critical_stretch: parameters are checked", "[fracture]") {
    const auto refusal = [](const std::string& table) {
        try {
            return message_of([&] { make<FractureCriterion, double>("critical_stretch", table); });
        } catch (const InvalidParameter& e) {
            return std::string(e.what());
        }
    };
    CHECK(contains(refusal("critical_stretch = 0"), "must be above 0"));
    CHECK(contains(refusal("critical_stretch = inf"), "must be finite"));
    CHECK(contains(refusal(""), "'fracture_energy' [J/m^2] is required: give one of the two"));
    CHECK(contains(refusal("critical_stretch = 1\nfracture_energy = 1"), "give one of the two"));
    CHECK(make<FractureCriterion, double>("critical_stretch", "critical_stretch = 0.1\ninterval = 7")->interval() == 7);
}

TEST_CASE("opening energy: springs of a cubic lattice, over that of many neighbours", "[fracture]") {
    struct Row {
        double horizon, ratio;
        const char* volumes;
    };
    for (const Row& row :
         {Row{2, 0.875, "none"}, Row{3, 1.148, "none"}, Row{3.015, 1.120, "none"}, Row{4, 0.913, "none"},
          Row{5, 0.966, "none"}, Row{6, 1.037, "none"}, Row{2, 1.146, "linear"}, Row{3, 1.071, "linear"},
          Row{3.015, 1.068, "linear"}, Row{4, 1.030, "linear"}, Row{5, 1.026, "linear"}, Row{6, 1.011, "linear"}}) {
        CAPTURE(row.horizon, row.volumes);
        const auto law = make<ConstitutiveLaw, double>(
            "pd_bond",
            fmt::format("youngs_modulus = 1.5\nhorizon = {}\ncalibration = \"continuum\"\nvolume_correction = \"{}\"",
                        row.horizon, row.volumes),
            {.density = 1, .particle_spacing = 1, .grid_spacing = 0});
        const double bulk = 1;  // E = 1.5, nu = 1/4
        CHECK_THAT(law->needs().opening_energy / (1.8 * bulk * row.horizon), WithinAbs(row.ratio, 1e-3));
    }
}

TEST_CASE("opening energy: it is what stretching the bonds across a plane costs", "[fracture]") {
    for (const char* law_name : {"pd_bond", "pd_elastic", "pd_lps"}) {
        for (const double nu : {0.25, 0.4}) {
            const bool lps = std::string(law_name) == "pd_lps";
            if (nu != 0.25 && !lps) continue;
            CAPTURE(law_name, nu);
            std::string table = "youngs_modulus = 1.0\nhorizon = 3.015\nsurface = \"none\"\n";
            if (lps) table += fmt::format("poisson_ratio = {}\n", nu);
            if (std::string(law_name) == "pd_elastic") table += "bending_ratio = 0.0\n";
            const auto law = make<ConstitutiveLaw, double>(law_name, table,
                                                           {.density = 1, .particle_spacing = 1, .grid_spacing = 0});
            // Two halves of a long column, of which only the energy of its middle row's families is counted. A small
            // opening u stretches a bond by u X_x/|X|^2 instead of alike: bonds are stretched one by one, instead.
            Particles<double> particles(*law, lattice(9, 1.0), 1.0);
            const double s = 1e-3;
            double energy = 0;
            for (int layer = 0; layer < 4; ++layer) {
                // One family at a time: every neighbour beyond the plane moves away from the middle particle by s |X|.
                const std::size_t p = middle(9);
                const Vec3 own = particles.reference()[p];
                particles.move(
                    [&](const Vec3& X) -> Vec3 { return X[0] - own[0] > layer + 0.5 ? own + (1 + s) * (X - own) : X; });
                energy += 2 * particles.energy(p, 1) / (s * s);
            }
            CHECK_THAT(law->needs().opening_energy, WithinRel(energy, 1e-6));
        }
    }
}

TEST_CASE("opening energy: the linear solid's integral over many neighbours", "[fracture]") {
    for (const double nu : {0.1, 0.25, 0.4}) {
        CAPTURE(nu);
        const double horizon = 10.5;
        const auto law = make<ConstitutiveLaw, double>(
            "pd_lps",
            fmt::format("youngs_modulus = 1.0\npoisson_ratio = {}\nhorizon = {}\ninfluence = \"inverse\"\n"
                        "volume_correction = \"linear\"",
                        nu, horizon),
            {.density = 1, .particle_spacing = 1, .grid_spacing = 0});
        const double mu = 0.5 / (1 + nu), bulk = 1 / (3 * (1 - 2 * nu));
        CHECK_THAT(law->needs().opening_energy / horizon, WithinRel(3 * mu + 26.0 / 45 * (bulk - 5 * mu / 3), 0.01));
    }
}

TEST_CASE("critical_stretch: from the fracture energy, as published", "[fracture]") {
    struct Row {
        double youngs_modulus, energy, horizon, stretch;
    };
    for (const Row& row :
         {Row{190e9, 22130, 3.015e-3, 5.674e-3}, Row{72e9, 3.8, 1e-3, 2.097e-4}, Row{32e9, 100, 6.7e-3, 6.234e-4}}) {
        CAPTURE(row.youngs_modulus);
        const double bulk = row.youngs_modulus / 1.5;  // nu = 1/4
        const auto criterion =
            make<FractureCriterion, double>("critical_stretch", fmt::format("fracture_energy = {}", row.energy),
                                            {.opening_energy = 1.8 * bulk * row.horizon});
        constexpr double kMargin = 1e-6;  // that is kept for rounding
        CHECK_THAT(criterion->harmless_stretch() + kMargin, WithinRel(row.stretch, 2e-4));
    }
    CHECK(contains(message_of<InvalidParameter>([] {
                       make<FractureCriterion, double>("critical_stretch", "fracture_energy = 1",
                                                       {.opening_energy = std::nan("")});
                   }),
                   "needs a law that knows the energy of its bonds"));
}
