// What holds for every installed fracture criterion, found through the registry.
#include <algorithm>
#include <set>

#include "support/every_model.hpp"
#include "support/particles.hpp"

using namespace perimpm;

namespace {

constexpr double kSpacing = 0.01;

template <class Real = double>
struct Sample {
    ModelPtr<ConstitutiveLaw, Real> law =
        make<ConstitutiveLaw, Real>("pd_bond", "youngs_modulus = 1e6\nhorizon = 2.01",
                                    {.density = 1000, .particle_spacing = kSpacing, .grid_spacing = 0});
    Particles<Real> particles{*law, lattice(6, kSpacing), kSpacing* kSpacing* kSpacing};
    ModelPtr<FractureCriterion, Real> criterion;

    explicit Sample(const std::string& name)
        : criterion{make<FractureCriterion, Real>(name, smallest_table(Family::fracture, name),
                                                  {.density = 1000, .particle_spacing = kSpacing, .grid_spacing = 0})} {
    }

    std::vector<BondCandidate> screen(std::size_t first, std::size_t count) {
        std::vector<BondCandidate> room(particles.bonds().size());
        CandidateList found{room.data(), 0};
        Block<Real> b = particles.block(first, count);
        particles.evaluate();
        auto energy = particles.bond_energies();
        for (auto& end : energy) end.resize(end.size() + kSlotPadding);
        b.stored = {energy[0].data() + b.family.row[0], energy[1].data() + b.family.row[0]};
        criterion->screen(b, found);
        room.resize(found.size);
        return room;
    }
};

const Eigen::Matrix3d kHuge = Vec3(50.0, 1.0, 1.0).asDiagonal();

}  // namespace

TEMPLATE_TEST_CASE("every criterion: a body at rest stays whole", "[contract]", float, double) {
    for (const std::string& name : names_of(Family::fracture)) {
        CAPTURE(name);
        Sample<TestType> sample(name);
        CHECK(sample.screen(0, sample.particles.size()).empty());
        sample.particles.deform(rotation(2.0, {1, 2, 3}));
        CHECK(sample.screen(0, sample.particles.size()).empty());
    }
}

TEST_CASE("every criterion: candidates are live bonds of the block, each once, whatever the split", "[contract]") {
    for (const std::string& name : names_of(Family::fracture)) {
        CAPTURE(name);
        Sample sample(name);
        Bonds& bonds = sample.particles.bonds();
        sample.particles.deform(kHuge);
        bonds.break_direction(0, 0);
        const auto whole = sample.screen(0, sample.particles.size());
        REQUIRE_FALSE(whole.empty());
        std::set<std::uint32_t> slots;
        for (const BondCandidate& c : whole) {
            CHECK((c.bond >= bonds.row[c.particle] && c.bond < bonds.row[c.particle + 1]));
            CHECK(c.bond != 0);
            CHECK(slots.insert(c.bond).second);
        }
        std::set<std::uint32_t> in_parts;
        for (std::size_t first = 0; first < sample.particles.size(); first += 50)
            for (const BondCandidate& c :
                 sample.screen(first, std::min<std::size_t>(50, sample.particles.size() - first)))
                in_parts.insert(c.bond);
        CHECK(in_parts == slots);
    }
}

TEST_CASE("every criterion: what is decided are live bonds, each once, and the same every time", "[contract]") {
    for (const std::string& name : names_of(Family::fracture)) {
        CAPTURE(name);
        Sample sample(name);
        CHECK(sample.criterion->interval() >= 1);
        sample.particles.deform(kHuge);
        const Bonds& bonds = sample.particles.bonds();
        sample.particles.bonds().break_direction(0, 0);
        sample.particles.bonds().break_direction(bonds.neighbour[0], bonds.opposite(0, 0));
        const auto found = sample.screen(0, sample.particles.size());
        std::vector<BondCandidate> cuts, again;
        sample.criterion->decide(sample.particles.block(), found, cuts);
        REQUIRE_FALSE(cuts.empty());
        std::set<std::uint32_t> slots;
        for (const BondCandidate& c : cuts) {
            CHECK((c.bond >= bonds.row[c.particle] && c.bond < bonds.row[c.particle + 1]));
            CHECK_FALSE(bonds.is_broken(c.bond));
            CHECK(slots.insert(c.bond).second);
        }
        sample.criterion->decide(sample.particles.block(), found, again);
        CHECK(std::equal(cuts.begin(), cuts.end(), again.begin(), again.end(),
                         [](const auto& a, const auto& b) { return a.bond == b.bond; }));
    }
}

TEST_CASE("every criterion: declared keys have unit and text, misspelt ones a suggestion", "[contract]") {
    for (const std::string& name : names_of(Family::fracture)) {
        CAPTURE(name);
        check_declaration(Family::fracture, name);
    }
}
