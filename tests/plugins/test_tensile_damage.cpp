// Closed forms of a bar in tension with nu = 0, where the principal stress is E times the strain.
#include "support/catch.hpp"
#include "support/message.hpp"
#include "support/model.hpp"
#include "support/particles.hpp"

using namespace perimpm;
using Eigen::Matrix3d;

namespace {

constexpr double kYoung = 1e6, kStrength = 1e3, kWidth = 0.1;  // breaks from a strain of 1e-3 on
const std::string kLaw =
    "law = { type = \"fixed_corotated\", youngs_modulus = 1e6, poisson_ratio = 0.0 }\ntensile_strength = 1e3\n";

ModelPtr<ConstitutiveLaw, double> law(const std::string& more = "") {
    return make<ConstitutiveLaw, double>("tensile_damage", kLaw + more,
                                         {.density = 1000, .particle_spacing = 0.05, .grid_spacing = kWidth});
}

struct Point {
    ModelPtr<ConstitutiveLaw, double> model;
    Particles<double> particle{*model, {Vec3::Zero()}, 1.0};

    /// Kirchhoff stress along x at this strain along x.
    double stress(double strain) {
        particle.set_F(0, Vec3(1 + strain, 1, 1).asDiagonal());
        particle.evaluate();
        return particle.tau(0)(0, 0);
    }
    double nominal(double strain) { return stress(strain) / (1 + strain); }
};

}  // namespace

TEST_CASE("tensile_damage: below its strength it is the law within, bit for bit", "[law]") {
    const auto plain = make<ConstitutiveLaw, double>("fixed_corotated", "youngs_modulus = 1e6\npoisson_ratio = 0.0");
    Particles<double> bare(*plain, {Vec3::Zero()}, 1.0);
    Point point{law()};
    for (const double strain : {0.9e-3, -0.3, 0.5e-3}) {
        bare.set_F(0, Vec3(1 + strain, 1, 1).asDiagonal());
        bare.evaluate();
        CHECK(point.stress(strain) == bare.tau(0)(0, 0));
        CHECK(point.particle.energy() == bare.energy());
    }
}

TEST_CASE("tensile_damage: pulling it apart takes the fracture energy of a band as wide as a cell", "[law]") {
    for (const double energy : {0.1, 0.2, 0.5}) {
        CAPTURE(energy);
        Point point{law("fracture_energy = " + std::to_string(energy))};
        const double last = 1e-3 + 20 * energy / (kWidth * kStrength), step = last / 20000;
        double work = 0, before = 0;
        for (double strain = step; strain <= last; strain += step) {
            const double now = point.nominal(strain);
            work += 0.5 * (before + now) * step;
            before = now;
        }
        CHECK_THAT(work * kWidth, WithinRel(energy, 0.02));  // strains are finite
        CHECK(before < 1e-6 * kStrength);
        CHECK(std::abs(point.particle.energy()) < 1e-3 * energy / kWidth);
    }
}

TEST_CASE("tensile_damage: without a fracture energy all tension is lost at once", "[law]") {
    Point point{law()};
    CHECK_THAT(point.stress(0.99e-3), WithinRel(0.99e3, 2e-3));
    CHECK(std::abs(point.stress(1.1e-3)) < 1e-9);
    CHECK(std::abs(point.stress(0.1e-3)) < 1e-9);  // for good
}

TEST_CASE("tensile_damage: it unloads towards the origin and closes under pressure", "[law]") {
    Point point{law("fracture_energy = 1.0")};
    const double loaded = point.nominal(5e-3);
    REQUIRE(loaded < 0.9 * kStrength);
    CHECK_THAT(point.nominal(2.5e-3), WithinRel(loaded / 2, 1e-3));
    CHECK_THAT(point.nominal(5e-3), WithinRel(loaded, 1e-9));
    CHECK_THAT(point.nominal(-5e-3), WithinRel(-5e-3 * kYoung, 1e-9));
}

TEST_CASE("tensile_damage: only tension is lost, across the crack", "[law]") {
    Point point{law()};
    point.stress(2e-3);
    point.particle.set_F(0, Vec3(1.002, 0.99, 1).asDiagonal());
    point.particle.evaluate();
    CHECK(std::abs(point.particle.tau(0)(0, 0)) < 1e-9);
    CHECK_THAT(point.particle.tau(0)(1, 1), WithinRel(-0.01 * kYoung * 0.99, 1e-9));
}

TEST_CASE("tensile_damage: what it cannot do is refused", "[law]") {
    const auto refusal = [](const std::string& more) { return message_of<InvalidParameter>([&] { law(more); }); };
    CHECK(contains(refusal("fracture_energy = 0.04"), "refine the grid"));  // f^2 w/(2 E) = 0.05
    CHECK(message_of<InvalidParameter>([] {
              make<ConstitutiveLaw, double>(
                  "tensile_damage", "law = { type = \"pd_bond\", youngs_modulus = 1e6 }\ntensile_strength = 1e3",
                  {.density = 1, .particle_spacing = 1, .grid_spacing = 2});
          }) != "(no error)");
}
