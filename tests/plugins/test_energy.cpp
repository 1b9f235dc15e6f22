// REFERENCES.md D1: what it takes to break every bond across a plane, one after the other, is the fracture energy.
#include <fmt/format.h>

#include <numbers>

#include "support/catch.hpp"
#include "support/message.hpp"
#include "support/model.hpp"
#include "support/particles.hpp"

using namespace perimpm;

namespace {

constexpr double kFractureEnergy = 1e-4;  // [J/m^2], for E = 1 Pa and a spacing of 1 m

/// A law and the criterion for its bonds, on a lattice of spacing 1.
struct Brittle {
    ModelContext context;
    ModelPtr<ConstitutiveLaw, double> law;
    ModelPtr<FractureCriterion, double> criterion;

    Brittle(const std::string& name, const std::string& table, std::uint32_t dimension = 3,
            const std::string& limit = fmt::format("fracture_energy = {}", kFractureEnergy))
        : context{.density = 1, .particle_spacing = 1, .dimension = dimension, .across = dimension == 3 ? 1.0 : 0.5},
          law{make<ConstitutiveLaw, double>(name, "youngs_modulus = 1\n" + table, context)} {
        context.horizon = law->needs().horizon, context.volumes = law->needs().volumes;
        criterion = make<FractureCriterion, double>("energy", limit, context);
    }
    double volume() const { return context.across; }

    std::vector<BondCandidate> screen(Particles<double>& particles) const {
        particles.evaluate();
        auto ends = particles.bond_energies();
        std::vector<BondCandidate> room(particles.bonds().size());
        CandidateList found{room.data(), 0};
        Block<double> b = particles.block();
        b.stored = {ends[0].data(), ends[1].data()};
        criterion->screen(b, found);
        room.resize(found.size);
        return room;
    }
    /// Energy of a pair when its bond breaks [J]: pulled apart along X, nothing else around.
    double at_break(const Vec3& X) const {
        Particles<double> pair(*law, {Vec3::Zero(), X}, volume());
        double low = 0, high = 1;
        for (int k = 0; k < 60; ++k) {
            const double stretch = 0.5 * (low + high);
            pair.place(1, (1 + stretch) * X);
            (screen(pair).empty() ? low : high) = stretch;
        }
        REQUIRE((low > 0 && high < 1));
        return pair.energy();
    }
};

}  // namespace

TEST_CASE("energy: breaking every bond across a plane costs the fracture energy", "[fracture]") {
    struct Row {
        const char *law, *table;
        std::uint32_t dimension;
    };
    for (const Row& row :
         {Row{"pd_bond", "volume_correction = \"none\"", 3},
          {"pd_bond", "volume_correction = \"linear\"", 3},
          {"pd_bond", "", 2},
          {"pd_lps", "poisson_ratio = 0.4", 3},
          {"pd_lps", "poisson_ratio = 0.1\ninfluence = \"inverse\"\nvolume_correction = \"linear\"", 3},
          {"pd_lps", "poisson_ratio = 0.3", 2},
          {"pd_elastic", "", 3},
          {"pd_elastic", "formulation = \"paper\"\ninfluence = \"constant\"", 3},
          {"pd_elastic", "bending_ratio = 0.0", 2}}) {
        CAPTURE(row.law, row.table, row.dimension);
        const Brittle brittle(row.law, std::string("horizon = 3.015\nsurface = \"none\"\n") + row.table, row.dimension);
        const double horizon = brittle.context.horizon;
        const int reach = static_cast<int>(horizon), wide = row.dimension == 3 ? reach : 0;
        double energy = 0;
        for (int i = 1; i <= reach; ++i)
            for (int j = -reach; j <= reach; ++j)
                for (int k = -wide; k <= wide; ++k)  // i bonds of this kind cross each cell of the plane
                    if (const Vec3 X(i, j, k); X.norm() < horizon) energy += i * brittle.at_break(X);
        CHECK_THAT(energy / brittle.volume(), WithinRel(kFractureEnergy, 1e-6));
    }
}

TEST_CASE("energy: with many neighbours bonds break at the published critical energy", "[fracture]") {
    const Brittle brittle("pd_bond", "horizon = 10.5\nsurface = \"none\"\nvolume_correction = \"linear\"");
    const double delta = 10.5;
    CHECK_THAT(brittle.at_break({3, 2, 1}),
               WithinRel(4 * kFractureEnergy / (std::numbers::pi * std::pow(delta, 4)), 0.01));
}

TEST_CASE("energy: compression breaks nothing, nor do bonds at rest", "[fracture]") {
    for (const char* law : {"pd_bond", "pd_lps", "pd_elastic"}) {
        CAPTURE(law);
        const Brittle brittle(law, "horizon = 2.01", 3, "critical_energy = 1e-6");
        Particles<double> particles(*brittle.law, lattice(6, 1.0), 1.0);
        CHECK(brittle.screen(particles).empty());
        particles.deform(0.5 * Eigen::Matrix3d::Identity());
        CHECK(brittle.screen(particles).empty());
        particles.deform(1.5 * Eigen::Matrix3d::Identity());
        CHECK(brittle.screen(particles).size() == particles.bonds().size());
    }
}

TEST_CASE("energy: parameters are checked", "[fracture]") {
    const auto refusal = [](const std::string& table) {
        try {
            return message_of([&] { make<FractureCriterion, double>("energy", table); });
        } catch (const InvalidParameter& e) {
            return std::string(e.what());
        }
    };
    CHECK(contains(refusal("critical_energy = 0"), "must be above 0"));
    CHECK(contains(refusal(""), "'fracture_energy' [J/m^2] is required: give one of the two"));
    CHECK(contains(refusal("critical_energy = 1\nfracture_energy = 1"), "give one of the two"));
    CHECK(make<FractureCriterion, double>("energy", "critical_energy = 1\ninterval = 7")->interval() == 7);
}
