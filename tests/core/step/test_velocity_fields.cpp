// kBox cut in two: halves of 4 x 8 x 8 particles at h = 0.05 m, 2 x 4 x 4 cells.
#include <set>

#include "state/morton.hpp"
#include "support/catch.hpp"
#include "support/message.hpp"
#include "support/world.hpp"

using namespace perimpm;

namespace {

const std::string kOwnFields = R"(material.rubber.crack_surface="fragment")";

std::unique_ptr<World<double>> halves(const Overrides& more = {}) {
    Overrides all = {kBonds, kCrack, kOwnFields};
    all.insert(all.end(), more.begin(), more.end());
    return box_world(all);
}
bool is_upper(const World<double>& w, std::size_t p) { return at(w.x, p)[1] > 0.2; }

std::uint32_t field_of(const World<double>& w, std::size_t p) { return w.fields.owners[w.fields.owner[p]].field; }

/// Gives the halves velocities, scatters them, and lets fields act on each other.
void throw_halves(World<double>& w, const Vec3& upper, const Vec3& lower) {
    for (std::size_t p = 0; p < w.count; ++p)
        for (int c = 0; c < 3; ++c) w.v[c][p] = (is_upper(w, p) ? upper : lower)[c];
    compute_bond_forces(w);
    scatter(w);
    resolve_field_contact(w);
}

/// Momentum with what impulses add, over mass, of a field's nodes.
Vec3 velocity_of(World<double>& w, std::uint32_t field) {
    Eigen::Vector4d sum = Eigen::Vector4d::Zero();
    std::set<std::uint32_t> blocks;
    for (std::size_t b = 0; b < w.grid.particle_blocks().size(); ++b)
        if (w.sort.blocks[b] >> kFieldShift == field)
            for (const std::uint32_t link : w.grid.particle_blocks()[b].links) blocks.insert(link);
    for (const std::uint32_t g : blocks)
        for (std::size_t k = 0; k < kBlockValues; ++k) {
            sum[static_cast<int>(k % 4)] += w.grid.nodes(g)[k];
            if (w.transfer_needs.increment && k % 4 < 3) sum[static_cast<int>(k % 4)] += w.grid.increments(g)[k];
        }
    return sum.head<3>() / sum[3];
}

}  // namespace

TEST_CASE("velocity fields: fragments that lie side by side have different ones", "[step]") {
    const auto w = halves();
    for (std::size_t p = 1; p < w->count; ++p)
        CHECK((field_of(*w, p) == field_of(*w, 0)) == (is_upper(*w, p) == is_upper(*w, 0)));
    CHECK_FALSE(w->grid.shared().empty());
    CHECK_FALSE(w->has_crack_surfaces);
}

TEST_CASE("velocity fields: fragments far from each other, and one alone, have the common one", "[step]") {
    const auto w = halves();
    for (std::size_t p = 0; p < w->count; ++p)
        if (is_upper(*w, p)) w->x[1][p] += 2;
    sort_particles(*w);
    for (std::size_t p = 0; p < w->count; ++p) CHECK(field_of(*w, p) == 0);
    CHECK(w->grid.shared().empty());
    const auto whole = box_world({kBonds, kNeverBreaks, kOwnFields});
    CHECK(whole->grid.shared().empty());
}

TEST_CASE("velocity fields: on one grid for all there are none", "[step]") {
    const auto w = box_world({kBonds, kCrack, kOnGrid});
    CHECK_FALSE(parts_fragments(*w));
    CHECK(w->fields.bytes() == 0);
    CHECK(w->grid.shared().empty());
}

TEST_CASE("velocity fields: halves that part or slide do not feel each other", "[step]") {
    // normals are tilted at the cut's edges: sliding halves feel a trace there
    for (const auto& [upper, trace] : {std::pair(Vec3(0, 1, 0), 1e-12), {Vec3(1, 0, 0.5), 2e-3}}) {
        CAPTURE(upper.transpose());
        const auto w = halves();
        throw_halves(*w, upper, -upper);
        const std::uint32_t field = field_of(*w, 0);
        const double sign = is_upper(*w, 0) ? 1 : -1;
        CHECK((velocity_of(*w, field) - sign * upper).norm() <= trace);
        CHECK((velocity_of(*w, 1 - field) + sign * upper).norm() <= trace);
    }
}

TEST_CASE("velocity fields: halves that meet stop each other, momentum is kept", "[step]") {
    for (const std::string transfer :
         {"transfer={ type = \"apic\" }", "transfer={ type = \"flip\" }", "transfer={ type = \"apic\", order = 3 }"}) {
        CAPTURE(transfer);
        const auto w = halves({transfer});
        const Vec3 upper(0.3, -1, 0), lower(0, 2, 0.1);
        throw_halves(*w, upper, lower);
        const std::uint32_t field = field_of(*w, 0), above = is_upper(*w, 0) ? field : 1 - field;
        const Vec3 up = velocity_of(*w, above), down = velocity_of(*w, 1 - above);
        CHECK((up + down - upper - lower).norm() <= 1e-12);  // of equal masses
        CHECK(up[1] > upper[1] + 0.3);                       // a layer of nodes in the halves' two cells has stopped
        CHECK(down[1] < lower[1] - 0.3);
        CHECK_THAT(up[0], WithinAbs(0.3, 0.02));  // no friction
        resolve_field_contact(*w);                // no node approaches any more
        CHECK((velocity_of(*w, above) - up).norm() <= 1e-12);
    }
}

TEST_CASE("velocity fields: momentum is kept where many meet", "[step]") {
    // three cuts: eight cubes that meet in a node, one thrown at the others
    const auto w = box_world({kBonds, kOwnFields,
                              R"(crack=[{ shape = { type = "plane", point = [0.2, 0.2, 0.2], normal = [1, 0, 0] } },)"
                              R"({ shape = { type = "plane", point = [0.2, 0.2, 0.2], normal = [0, 1, 0] } },)"
                              R"({ shape = { type = "plane", point = [0.2, 0.2, 0.2], normal = [0, 0, 1] } }])"});
    std::set<std::uint32_t> fields;
    for (std::size_t p = 0; p < w->count; ++p) fields.insert(field_of(*w, p));
    CHECK(fields.size() == 8);
    for (std::size_t p = 0; p < w->count; ++p)
        for (int c = 0; c < 3; ++c) w->v[c][p] = field_of(*w, p) == field_of(*w, 0) ? (w->x[c][0] < 0.2 ? 1 : -1) : 0;
    compute_bond_forces(*w);
    scatter(*w);
    const Eigen::Vector4d before = node_sums(*w);
    const Vec3 thrown = velocity_of(*w, field_of(*w, 0));
    resolve_field_contact(*w);
    CHECK((node_sums(*w) - before).norm() <= 1e-12 * before.norm());
    CHECK(velocity_of(*w, field_of(*w, 0)).norm() < 0.9 * thrown.norm());
}

TEST_CASE("velocity fields: bodies that are whole have the common one, and so have sheets", "[step]") {
    const auto two =
        box_world({kBonds, kOwnFields,
                   R"(crack=[{ body = "cut", shape = { type = "plane", point = [0, 0.2, 0], normal = [0, 1, 0] } }])",
                   R"(body=[{ name = "cut", material = "rubber", particle_spacing = 0.05, )"
                   R"(shape = { type = "box", min = [0, 0, 0], max = [0.4, 0.4, 0.4] } }, )"
                   R"({ material = "rubber", particle_spacing = 0.05, )"
                   R"(shape = { type = "box", min = [0.45, 0, 0], max = [0.65, 0.4, 0.4] } }])"});
    std::set<std::uint32_t> fields;
    for (std::size_t p = 0; p < two->count; ++p) {
        fields.insert(field_of(*two, p));
        CHECK((field_of(*two, p) == 0) == (at(two->x, p)[0] > 0.42));
    }
    CHECK(fields.size() == 3);
    const auto sheet = box_world(
        {kBonds, kCrack,
         R"(body.0.shape={ type = "rectangle", corner = [0, 0, 0], edge_u = [0.4, 0, 0], edge_v = [0, 0.4, 0] })",
         "body.0.thickness=0.01"});
    CHECK_FALSE(parts_fragments(*sheet));
    CHECK(sheet->has_crack_surfaces);
}

TEST_CASE("velocity fields: a material of which nothing can part refuses to be asked", "[step]") {
    CHECK(contains(message_of([] { box_world({kBonds, kOwnFields}); }), "'crack_surface' of material 'rubber'"));
    CHECK(contains(message_of([] {
                       box_world({kBonds, kCrack, kOwnFields, kNoGrid, "grid.spacing=0.1"});
                   }),
                   "'crack_surface' of material 'rubber'"));
}

TEST_CASE("velocity fields: halves with a gap between them do not touch yet", "[step]") {
    const auto w = halves();
    for (std::size_t p = 0; p < w->count; ++p)
        if (is_upper(*w, p)) w->x[1][p] += 0.06;  // 0.6 of a cell: their nodes are still the same
    sort_particles(*w);
    REQUIRE_FALSE(w->grid.shared().empty());
    throw_halves(*w, Vec3(0, -1, 0), Vec3(0, 1, 0));
    const std::uint32_t field = field_of(*w, 0);
    CHECK_THAT(std::abs(velocity_of(*w, field)[1]), WithinAbs(1, 1e-4));
}

TEST_CASE("velocity fields: dust shares one", "[step]") {
    // two particles on either side of the cut
    const auto w = box_world({kBonds, kOwnFields, kRow,
                              R"(crack=[{ shape = { type = "plane", point = [0.1, 0, 0], normal = [1, 0, 0] } }])"});
    REQUIRE(w->count == 4);
    std::set<std::uint32_t> fields;
    for (std::size_t p = 0; p < w->count; ++p) fields.insert(w->fields.owner[p]);
    CHECK(fields.size() == 1);
}

TEST_CASE("velocity fields: when bonds break, the next step sorts the fragments apart", "[step]") {
    const auto w = box_world(
        {kBonds, kOwnFields, R"(material.rubber.fracture={ type = "critical_stretch", critical_stretch = 0.01 })"});
    CHECK(w->fields.bytes() == 0);
    for (std::size_t p = 0; p < w->count; ++p)
        if (is_upper(*w, p)) w->x[1][p] += 0.02;
    compute_bond_forces(*w);
    REQUIRE(w->fields.is_stale);
    CHECK(find_owners(*w));
    CHECK_FALSE(w->fields.is_stale);
    CHECK_FALSE(find_owners(*w));  // nothing has parted since
    sort_particles(*w);
    CHECK(w->fields.owners.size() == 4);  // the common one, two halves, dust
    CHECK_FALSE(w->grid.shared().empty());
}
