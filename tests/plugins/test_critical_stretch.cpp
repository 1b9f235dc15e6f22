// REFERENCES.md D6: share of bonds broken by a homogeneous strain of a full family.
#include <fmt/format.h>

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
        return message_of([&] { make<FractureCriterion, double>("critical_stretch", table); });
    };
    CHECK(contains(refusal("critical_stretch = 0"), "must be above 0"));
    CHECK(contains(refusal("critical_stretch = inf"), "must be finite"));
    CHECK(contains(refusal(""), "missing key 'critical_stretch'"));
    CHECK(make<FractureCriterion, double>("critical_stretch", "critical_stretch = 0.1\ninterval = 7")->interval() == 7);
}
