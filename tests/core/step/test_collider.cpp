#include <numbers>

#include "step/collider.hpp"
#include "support/catch.hpp"

using namespace perimpm;

namespace {

const Vec3 kUp = Vec3::UnitY();

ColliderSpec still() {
    return {.name = "floor",
            .shape = {},
            .contact = Contact::separate,
            .friction = 0.0,
            .velocity = Vec3::Zero(),
            .angular_velocity = Vec3::Zero(),
            .pivot = Vec3::Zero(),
            .source = {}};
}

/// The half space below y = 0.
class Floor final : public Shape {
public:
    double signed_distance(const Vec3& x) const override { return x[1]; }
    Vec3 normal(const Vec3&) const override { return kUp; }
    Box3 bounds() const override {
        const Vec3 far = Vec3::Constant(std::numeric_limits<double>::infinity());
        return {-far, Vec3(far[0], 0.0, far[2])};
    }
};

Collider floor_collider(const ColliderSpec& spec) { return {spec, std::make_shared<Floor>()}; }

}  // namespace

TEST_CASE("contact: sticky takes everything, slip the normal part", "[step]") {
    const Vec3 v(3.0, -2.0, 4.0);
    CHECK(resolve_contact(v, kUp, Contact::sticky, 0.0) == Vec3::Zero());
    CHECK(resolve_contact(v, kUp, Contact::slip, 0.0) == Vec3(3.0, 0.0, 4.0));
    CHECK(resolve_contact(-v, kUp, Contact::slip, 0.0) == Vec3(-3.0, 0.0, -4.0));
}

TEST_CASE("contact: separate lets go, and holds what approaches", "[step]") {
    const Vec3 leaving(3.0, 2.0, 4.0);
    CHECK(resolve_contact(leaving, kUp, Contact::separate, 0.9) == leaving);
    CHECK(resolve_contact({3.0, -2.0, 4.0}, kUp, Contact::separate, 0.0) == Vec3(3.0, 0.0, 4.0));
    CHECK(resolve_contact({3.0, 0.0, 4.0}, kUp, Contact::separate, 0.9) == Vec3(3.0, 0.0, 4.0));
}

TEST_CASE("contact: Coulomb friction takes mu times the normal change, at most all", "[step]") {
    const Vec3 v(3.0, -2.0, 4.0);  // 5 along the floor, 2 into it
    const Vec3 slid = resolve_contact(v, kUp, Contact::separate, 0.5);
    CHECK((slid - (1 - 0.5 * 2 / 5) * Vec3(3.0, 0.0, 4.0)).norm() <= 1e-15);
    CHECK(resolve_contact(v, kUp, Contact::separate, 2.5) == Vec3::Zero());  // 2.5 * 2 = 5: just sticks
    CHECK(resolve_contact(v, kUp, Contact::separate, 100.0) == Vec3::Zero());
    CHECK(resolve_contact({0.0, -2.0, 0.0}, kUp, Contact::separate, 0.5) == Vec3::Zero());
}

TEST_CASE("contact: a slope turns the closed form with it", "[step]") {
    const Vec3 n(0.6, 0.8, 0.0), along(0.8, -0.6, 0.0);
    const Vec3 v = 4.0 * along - 1.0 * n;
    CHECK((resolve_contact(v, n, Contact::separate, 0.25) - 3.75 * along).norm() <= 1e-15);
}

TEST_CASE("collider: a moving one resolves relative velocities", "[step]") {
    ColliderSpec spec = still();
    spec.velocity = {0.0, 1.0, 0.0};
    Collider lift = floor_collider(spec);
    lift.set_time(2.0);
    CHECK(lift.signed_distance({5.0, 3.0, 0.0}) == Approx(1.0));
    CHECK(lift.resolve(Vec3::Zero(), {1.0, 0.5, 0.0}) == Vec3(1.0, 1.0, 0.0));  // slower than the lift
    CHECK(lift.resolve(Vec3::Zero(), {1.0, 1.5, 0.0}) == Vec3(1.0, 1.5, 0.0));  // leaves it
    CHECK(lift.max_speed() == 1.0);
}

TEST_CASE("collider: rotation turns shape, normal and velocity about the moving pivot", "[step]") {
    ColliderSpec spec = still();
    spec.contact = Contact::sticky;
    spec.pivot = {1.0, 0.0, 0.0};
    spec.velocity = {2.0, 0.0, 0.0};
    spec.angular_velocity = {0.0, 0.0, std::numbers::pi / 2};
    Collider wheel = floor_collider(spec);
    wheel.set_time(1.0);  // a quarter turn: the floor's up has become -x, the pivot lies at (3, 0, 0)
    CHECK((wheel.normal(Vec3::Zero()) + Vec3::UnitX()).norm() <= 1e-15);
    CHECK(wheel.signed_distance({2.5, 7.0, 1.0}) == Approx(0.5));
    CHECK(wheel.signed_distance({4.0, 7.0, 1.0}) == Approx(-1.0));
    const Vec3 at(3.0, 2.0, 0.0);  // two above the pivot: omega x r = (-pi, 0, 0)
    CHECK((wheel.velocity(at) - Vec3(2.0 - std::numbers::pi, 0.0, 0.0)).norm() <= 1e-14);
    CHECK((wheel.resolve(at, Vec3::Zero()) - wheel.velocity(at)).norm() <= 1e-15);
}

TEST_CASE("collider: what holds at all times is sticky, or slip without friction", "[step]") {
    ColliderSpec spec = still();
    spec.friction = 10.0;
    spec.velocity = {0.0, 1.0, 0.0};
    const Vec3 v(3.0, -2.0, 4.0);
    CHECK(floor_collider(spec).hold(Vec3::Zero(), v) == v);
    spec.contact = Contact::slip;
    CHECK(floor_collider(spec).hold(Vec3::Zero(), v) == Vec3(3.0, 1.0, 4.0));
    spec.contact = Contact::sticky;
    CHECK(floor_collider(spec).hold(Vec3::Zero(), v) == Vec3(0.0, 1.0, 0.0));
}
