// Runs a scene with the plugin of this folder and compares with closed forms. Returns 0 when all agree.
#include <cmath>
#include <cstdio>
#include <perimpm/error.hpp>
#include <perimpm/step/simulation.hpp>

namespace {

const char* const kScene = R"(format = 1
[simulation]
end_time = 1.0
precision = "double"
gravity = [0, 0, -10]
[grid]
spacing = 0.1
[transfer]
type = "apic"
[material.rubber]
density = 1000.0
constitutive = { type = "saint_venant_kirchhoff", youngs_modulus = 1e5, poisson_ratio = 0.25 }
[[body]]
material = "rubber"
shape = { type = "box", min = [0, 0, 0], max = [0.5, 0.5, 0.5] }
)";

int failures = 0;

void check(const char* what, double value, double expected) {
    const bool agrees = std::abs(value - expected) <= 1e-9 * std::abs(expected);
    std::printf("%-28s %.12g   expected %.12g   %s\n", what, value, expected, agrees ? "ok" : "WRONG");
    failures += !agrees;
}

}  // namespace

int main() try {
    perimpm::Simulation sim(perimpm::read_scene(perimpm::parse_scene_text(kScene, "check.toml"), "."));
    const double E = 1e5, nu = 0.25, lambda = E * nu / ((1 + nu) * (1 - 2 * nu)), mu = E / (2 * (1 + nu)),
                 volume = 0.125;
    check("wave speed at rest [m/s]", sim.plan().materials[0].wave_speed, std::sqrt((lambda + 2 * mu) / 1000));

    // Stretch every particle by 1.2 along x: E_xx = (1.44 - 1)/2 and W = (lambda/2 + mu) E_xx^2.
    const perimpm::FieldView F = sim.field("F");
    for (std::size_t p = 0; p < F.size; ++p) static_cast<double*>(F.data)[p] = 1.2;
    check("energy when stretched [J]", sim.ledger().elastic, volume * (lambda / 2 + mu) * 0.22 * 0.22);

    // However it wobbles from there, momentum follows gravity alone: m g t.
    for (int step = 0; step < 50; ++step) sim.step();
    check("momentum [kg m/s]", sim.ledger().momentum[2], -10.0 * 1000 * volume * sim.time());
    return failures == 0 ? 0 : 1;
} catch (const perimpm::InputError& e) {
    std::fprintf(stderr, "%s\n", e.what());
    return 2;
}
