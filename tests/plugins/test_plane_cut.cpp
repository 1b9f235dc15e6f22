// The stages of the criterion of Lyu et al. 2019, each by what it alone decides.
#include <fmt/format.h>

#include <set>

#include "support/catch.hpp"
#include "support/message.hpp"
#include "support/model.hpp"
#include "support/particles.hpp"

using namespace perimpm;

namespace {

constexpr int kCount = 8;

struct Cube {
    ModelPtr<ConstitutiveLaw, double> law = make<ConstitutiveLaw, double>(
        "pd_bond", "youngs_modulus = 1\nhorizon = 2.01", {.density = 1, .particle_spacing = 1, .grid_spacing = 2});
    Particles<double> particles{*law, lattice(kCount, 1.0), 1.0};

    std::vector<BondCandidate> screen(const FractureCriterion<double>& criterion) {
        std::vector<BondCandidate> room(particles.bonds().size());
        CandidateList found{room.data(), 0};
        criterion.screen(particles.block(), found);
        room.resize(found.size);
        return room;
    }
    std::vector<BondCandidate> cuts(const FractureCriterion<double>& criterion) {
        std::vector<BondCandidate> out;
        const auto found = screen(criterion);
        if (!found.empty()) criterion.decide(particles.block(), found, out);
        return out;
    }
    /// Bonds as pairs of positions at the start.
    std::pair<Vec3, Vec3> ends(const BondCandidate& c) const {
        return {particles.reference()[c.particle], particles.reference()[particles.bonds().neighbour[c.bond]]};
    }
    /// Moves everything beyond X = at by `by` along x.
    void part(double at, double by) {
        particles.move([&](const Vec3& X) -> Vec3 { return X + Vec3(X[0] > at ? by : 0, 0, 0); });
    }
    double middle_plane() const { return particles.reference()[0][0] + (kCount - 1) / 2.0; }
};

ModelPtr<FractureCriterion, double> criterion(const std::string& table) {
    return make<FractureCriterion, double>("plane_cut", table,
                                           {.density = 1, .particle_spacing = 1, .grid_spacing = 2});
}

}  // namespace

TEST_CASE("plane_cut: screening is by strain, or by strain over length", "[fracture]") {
    Cube cube;
    cube.particles.deform(Vec3(1.2, 1, 1).asDiagonal());  // bonds along x: strain 0.2, of length 1 and 2
    const auto along_x = [&](const auto& criterion) {
        std::set<double> lengths;
        for (const BondCandidate& c : cube.screen(*criterion)) {
            const auto [X, other] = cube.ends(c);
            if (std::abs((other - X)[0]) > (other - X).norm() - 1e-9) lengths.insert((other - X).norm());
        }
        return lengths;
    };
    CHECK(along_x(criterion("threshold = 0.19")) == std::set<double>{1, 2});
    CHECK(along_x(criterion("threshold = 0.21")).empty());
    CHECK(along_x(criterion("threshold = 0.15\nmeasure = \"paper\"")) == std::set<double>{1});
    CHECK(along_x(criterion("threshold = 0.09\nmeasure = \"paper\"")) == std::set<double>{1, 2});
}

TEST_CASE("plane_cut: one area is cut along one plane, all the way", "[fracture]") {
    Cube cube;
    cube.part(cube.middle_plane(), 0.3);
    const auto cuts = cube.cuts(*criterion("threshold = 0.25"));
    std::size_t crossing = 0;
    for (std::uint32_t p = 0; p < cube.particles.size(); ++p)
        for (std::uint32_t s = cube.particles.bonds().row[p]; s < cube.particles.bonds().row[p + 1]; ++s)
            crossing += cube.particles.reference()[p][0] < cube.middle_plane() &&
                        cube.particles.reference()[cube.particles.bonds().neighbour[s]][0] > cube.middle_plane();
    CHECK(cuts.size() == crossing);  // those that (12) leaves alone, too
    for (const BondCandidate& c : cuts) {
        const auto [X, other] = cube.ends(c);
        CHECK((X[0] - cube.middle_plane()) * (other[0] - cube.middle_plane()) < 0);
    }
}

TEST_CASE("plane_cut: areas apart, or across each other, are cut by themselves", "[fracture]") {
    Cube cube;
    const double low = cube.particles.reference()[0][0] + 0.5, high = low + kCount - 2;
    cube.particles.move([&](const Vec3& X) -> Vec3 {
        return X + Vec3(X[0] < low ? -0.3 : X[0] > high ? 0.3 : 0, 0, 0);  // two planes, 6 spacings apart
    });
    std::set<double> where;
    for (const BondCandidate& c : cube.cuts(*criterion("threshold = 0.25"))) {
        const auto [X, other] = cube.ends(c);
        where.insert((X[0] < low) != (other[0] < low) ? low : (X[0] > high) != (other[0] > high) ? high : 0.0);
    }
    CHECK(where == std::set<double>{low, high});
}

TEST_CASE("plane_cut: a plane ends where its area ends", "[fracture]") {
    Cube cube;
    const double edge = cube.particles.reference()[0][1] + 2.5;  // only the first three rows along y part
    cube.particles.move(
        [&](const Vec3& X) -> Vec3 { return X + Vec3(X[0] > cube.middle_plane() && X[1] < edge ? 0.3 : 0, 0, 0); });
    const auto cuts = cube.cuts(*criterion("threshold = 0.28\nangle = 20"));
    REQUIRE_FALSE(cuts.empty());
    for (const BondCandidate& c : cuts) {
        const auto [X, other] = cube.ends(c);
        CHECK(std::min(X[1], other[1]) < edge);
    }
}

TEST_CASE("plane_cut: bonds among broken ones are in question later", "[fracture]") {
    Cube cube;
    Bonds& bonds = cube.particles.bonds();
    for (std::uint32_t p = 0; p < cube.particles.size(); ++p)  // every second bond
        for (std::uint32_t s = bonds.row[p]; s < bonds.row[p + 1]; s += 2)
            if (bonds.break_direction(p, s)) bonds.break_direction(bonds.neighbour[s], bonds.opposite(p, s));
    cube.particles.deform(Vec3(1.2, 1, 1).asDiagonal());
    CHECK(cube.cuts(*criterion("threshold = 0.15")).empty());
    CHECK_FALSE(cube.cuts(*criterion("threshold = 0.15\np_inactive = false")).empty());
    CHECK_FALSE(cube.cuts(*criterion("threshold = 0.08")).empty());
}
