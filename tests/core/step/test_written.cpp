#include <limits>

#include "perimpm/error.hpp"
#include "support/catch.hpp"
#include "support/message.hpp"
#include "support/world.hpp"

using namespace perimpm;

TEMPLATE_TEST_CASE("written: positions make a step sort again and drop forces of other places", "[step]", float,
                   double) {
    const auto w = box_world<TestType>();
    w->drift = 0, w->forces_known = true;
    accept_positions(*w);
    CHECK(w->drift == w->spacing());  // more than a step lets stand
    CHECK_FALSE(w->forces_known);
}

TEMPLATE_TEST_CASE("written: the time step sees the largest speed written", "[step]", float, double) {
    const auto w = box_world<TestType>();
    w->v[0][100] = 3, w->v[1][100] = -4;
    w->v[2][511] = -12, w->v[0][511] = 4, w->v[1][511] = 3;  // |v| = 13
    accept_velocities(*w);
    CHECK_THAT(w->max_speed, WithinRel(13.0, 1e-15));
    for (const std::size_t p : {100, 511})
        for (int c = 0; c < 3; ++c) w->v[c][p] = 0;
    accept_velocities(*w);
    CHECK(w->max_speed == 0);
}

TEMPLATE_TEST_CASE("written: what is not finite is refused by field, particle and component", "[step]", float, double) {
    const auto w = box_world<TestType>();
    const std::string particle = "of particle " + std::to_string(w->id[7]) + " is not finite: component ";
    w->x[1][7] = std::numeric_limits<TestType>::quiet_NaN();
    w->v[2][7] = -std::numeric_limits<TestType>::infinity();
    w->drift = 0;
    CHECK(contains(message_of<SimulationError>([&] { accept_positions(*w); }),
                   "the position written into 'x' " + particle + "y is nan"));
    CHECK(w->drift == 0);
    CHECK(contains(message_of<SimulationError>([&] { accept_velocities(*w); }),
                   "the velocity written into 'v' " + particle + "z is -inf"));
}

TEST_CASE("written: positions of a bond law renew its wave speed", "[step]") {
    const auto w = box_world({kBonds});
    const double before = w->wave_speed;
    for (std::size_t p = 0; p < w->count; ++p) w->x[0][p] *= 1.5;
    accept_positions(*w);
    CHECK_THAT(w->wave_speed, WithinRel(1.5 * before, 1e-9));  // bonds along x are 1.5 times as long
}

TEST_CASE("written: masses and volumes are above 0 and finite", "[step]") {
    const auto w = box_world<double>();
    w->mass[7] *= 2, w->volume[7] *= 0.5;
    accept_weights(*w);
    for (const double bad :
         {0.0, -1.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()})
        for (auto* values : {&w->mass, &w->volume}) {
            const double before = (*values)[7];
            (*values)[7] = bad;
            CHECK(contains(message_of<SimulationError>([&] { accept_weights(*w); }),
                           "of particle " + std::to_string(w->id[7]) + " is "));
            (*values)[7] = before;
        }
}

TEST_CASE("written: bonds keep their particles' volumes", "[step]") {
    const auto w = box_world({kBonds});
    w->volume[3] *= 2;
    CHECK(contains(message_of<SimulationError>([&] { accept_weights(*w); }), "'rubber' keep the 0.000125 m^3"));
}

TEST_CASE("written: the wave speed is that of the particle lightest for its volume", "[step]") {
    for (const Overrides& overrides : {Overrides{}, Overrides{kBonds}}) {
        const auto w = box_world(overrides);
        const double before = w->wave_speed;
        for (std::size_t p = 0; p < w->count; ++p) w->mass[p] *= 4;
        accept_weights(*w);
        CHECK_THAT(w->wave_speed, WithinRel(before / 2, 1e-12));
        w->mass[100] /= 100;  // a 25th of the density
        accept_weights(*w);
        CHECK_THAT(w->wave_speed, WithinRel(5 * before, 1e-12));
        measure_wave_speed(*w);
        CHECK_THAT(w->wave_speed, WithinRel(5 * before, 1e-12));
    }
}

TEST_CASE("written: deformation gradients are finite and renew the wave speed", "[step]") {
    const auto w = box_world<double>();
    const double before = w->wave_speed;
    for (std::size_t p = 0; p < w->count; ++p) w->materials[0].F[0][p] = 4;
    accept_deformations(*w);
    CHECK(w->wave_speed > 1.5 * before);
    w->materials[0].F[5][7] = std::numeric_limits<double>::quiet_NaN();
    CHECK(contains(message_of<SimulationError>([&] { accept_deformations(*w); }),
                   "'F' of particle " + std::to_string(w->id[7]) + " is not finite: component yz is nan"));
}
