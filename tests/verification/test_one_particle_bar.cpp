// One-particle bar, REFERENCES.md A1: closed form of the semi-discrete scheme, so that only the time integration errs.
//   one linear cell [0, 1] m, left nodes fixed, one particle at x0 = 1/2, E = 4 pi^2 Pa, rho = 1 kg/m^3, Hencky with nu = 0
//   v(t) = v0 cos(w t),  x(t) = x0 exp(v0/w sin(w t)),  tau(t) = E v0/w sin(w t),  w = sqrt(E/rho)/L = 2 pi/s
#include <cmath>
#include <numbers>

#include "support/catch.hpp"
#include "support/environment.hpp"
#include "support/scene.hpp"

using namespace perimpm;

namespace {

constexpr double kOmega = 2 * std::numbers::pi, kSpeed = 0.1, kPeriods = 10;

const char* const kBar = R"(format = 1
[simulation]
end_time = 10
precision = "double"
gravity = [0, 0, 0]
[grid]
spacing = 1
domain = { min = [0, 0, 0], max = [4, 1, 1], faces = { min_x = "sticky", max_x = "open", min_y = "open", max_y = "open", min_z = "open", max_z = "open" } }
[transfer]
type = "flip"
order = 1
blend = 1.0
[material.bar]
density = 1
constitutive = { type = "hencky", youngs_modulus = 39.47841760435743 }
[[body]]
material = "bar"
particle_spacing = 1
shape = { type = "box", min = [0, 0, 0], max = [1, 1, 1] }
)";

struct Errors {
    double speed, place, amplitude;  ///< largest |v - v_ex|/v0, |x - x_ex|/x0; amplitude lost or gained per period, relative
};

/// Runs ten periods; the velocity is read at t_n + `read_at` dt, where the first one is set as well.
Errors run(double dt, double read_at) {
    const EnvironmentVariable path{"PERIMPM_PLUGIN_PATH", PERIMPM_TEST_PLUGINS};
    Simulation bar(scene_from(kBar, {"simulation.dt=" + std::to_string(dt)}), 1);
    REQUIRE(bar.particle_count() == 1);
    const double spring = kOmega * kOmega / (kSpeed * kSpeed);
    const auto steps = static_cast<int>(std::lround(kPeriods / dt));
    Errors worst{0, 0, 0};
    double first = 0, last = 0;
    entry(bar.field("v"), 0) = kSpeed * std::cos(kOmega * read_at * dt);
    for (int n = 1; n <= steps; ++n) {
        bar.step();
        const double t = n * dt, v = entry(bar.field("v"), 0), x = entry(bar.field("x"), 0);
        const double exact_v = kSpeed * std::cos(kOmega * (t + read_at * dt));
        const double exact_x = 0.5 * std::exp(kSpeed / kOmega * std::sin(kOmega * t));
        worst.speed = std::max(worst.speed, std::abs(v - exact_v) / kSpeed);
        worst.place = std::max(worst.place, std::abs(x - exact_x) / 0.5);
        const double strain = std::log(x / 0.5);
        const double amplitude = std::sqrt(v * v / (kSpeed * kSpeed) + spring * strain * strain);
        const double period = std::round(1 / dt);
        if (n <= period) first = std::max(first, amplitude);
        if (n > steps - period) last = std::max(last, amplitude);
    }
    worst.amplitude = std::abs(last / first - 1) / (kPeriods - 1);
    return worst;
}

double order(double coarse, double fine) { return std::log2(coarse / fine); }

}  // namespace

TEST_CASE("one-particle bar: second order when the velocity lives half a step before the position", "[verification]") {
    const Errors a = run(0.01, -0.5), b = run(0.005, -0.5), c = run(0.0025, -0.5);
    CAPTURE(a.speed, b.speed, c.speed, a.place, b.place, c.place);
    CHECK(order(a.speed, b.speed) > 1.9);
    CHECK(order(b.speed, c.speed) > 1.8);
    CHECK(order(a.place, b.place) > 1.9);
    // Phase error of the leapfrog oscillator: w dt/24 (w dt) per radian, ten periods
    CHECK(a.speed < 1.2 * 2 * std::numbers::pi * kPeriods * std::pow(kOmega * 0.01, 2) / 24);
    CHECK(a.amplitude < 1e-3);
}

TEST_CASE("one-particle bar: first order when the velocity is read at the position's time", "[verification]") {
    const Errors a = run(0.01, 0.0), b = run(0.005, 0.0), c = run(0.0025, 0.0);
    CAPTURE(a.speed, b.speed, c.speed);
    CHECK_THAT(order(a.speed, b.speed), WithinAbs(1.0, 0.2));
    CHECK_THAT(order(b.speed, c.speed), WithinAbs(1.0, 0.2));
    CHECK(a.amplitude < 1e-3);
}

TEST_CASE("one-particle bar: stress follows the closed form", "[verification]") {
    const EnvironmentVariable path{"PERIMPM_PLUGIN_PATH", PERIMPM_TEST_PLUGINS};
    const double dt = 0.0025;
    Simulation bar(scene_from(kBar, {"simulation.dt=" + std::to_string(dt)}), 1);
    entry(bar.field("v"), 0) = kSpeed * std::cos(kOmega * 0.5 * dt);
    for (int n = 1; n <= 400; ++n) {
        bar.step();
        const double tau = kOmega * kOmega * std::log(entry(bar.field("F"), 0));
        CHECK_THAT(tau, WithinAbs(kOmega * kSpeed * std::sin(kOmega * n * dt), 2e-3 * kOmega * kSpeed));
    }
}
