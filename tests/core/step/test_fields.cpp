#include <algorithm>
#include <cstring>
#include <set>

#include "perimpm/error.hpp"
#include "support/catch.hpp"
#include "support/message.hpp"
#include "support/world.hpp"

using namespace perimpm;

namespace {

std::set<std::string> names(const std::vector<FieldView>& views) {
    std::set<std::string> out;
    for (const FieldView& v : views) out.insert(v.name);
    return out;
}

/// kBox and a second cube of a bond law beside it.
const Overrides kTwo = {
    R"(material.glass={ density = 1000, constitutive = { type = "pd_bond", youngs_modulus = 1e5 } })",
    R"(body=[{ material = "glass", particle_spacing = 0.1, shape = { type = "box", min = [1, 0, 0], max = [1.2, 0.2, 0.2] } },)"
    R"({ material = "rubber", particle_spacing = 0.1, shape = { type = "box", min = [0, 0, 0], max = [0.2, 0.2, 0.2] } }])"};

template <class T>
T value(const FrameField& f, std::size_t i) {
    T out;
    std::memcpy(&out, f.data.data() + i * sizeof(T), sizeof(T));
    return out;
}

}  // namespace

TEST_CASE("fields: those of all particles, and those of one material", "[step]") {
    const std::set<std::string> common{"x", "v", "C", "mass", "volume", "id"};
    auto with = [&](std::set<std::string> more) { return more.insert(common.begin(), common.end()), more; };
    CHECK(names(list_fields(*box_world(), "")) == with({"F"}));
    const auto two = box_world(kTwo);
    CHECK(names(list_fields(*two, "")) == common);
    CHECK(names(list_fields(*two, "rubber")) == with({"F"}));
    CHECK(names(list_fields(*two, "glass")) == with({"force", "normalisation"}));
    CHECK(contains(message_of([&] { list_fields(*two, "ruber"); }), "did you mean 'rubber'?"));
}

TEST_CASE("fields: a view is the memory itself", "[step]") {
    const auto w = box_world(kTwo);
    for (const FieldView& v : list_fields(*w, "rubber")) {
        CHECK(v.size == 8);
        if (v.name != "x") continue;
        CHECK(v.data == w->x[0] + w->materials[0].begin);
        CHECK(v.components == 3);
        static_cast<double*>(v.data)[v.stride] = 7;
        CHECK(w->x[1][w->materials[0].begin] == 7);
    }
}

TEST_CASE("fields: frames are in the order of ids, whatever materials and sorting did", "[step]") {
    Overrides overrides = kTwo;
    overrides.push_back(R"(output={ fields = ["x", "id", "body", "F", "force"] })");
    const auto w = box_world(overrides);
    const Frame frame = make_frame(*w, 3, w->scene.output.fields);
    CHECK(frame.number == 3);
    REQUIRE(frame.rows == 16);
    REQUIRE(frame.fields.size() == 5);
    for (std::size_t i = 0; i < 16; ++i) {
        CHECK(value<std::uint32_t>(frame.fields[1], i) == i);
        CHECK(value<std::uint32_t>(frame.fields[2], i) == i / 8);
        CHECK((value<double>(frame.fields[0], 3 * i) > 0.5) == (i < 8));  // glass comes first
        CHECK(std::isnan(value<double>(frame.fields[3], 9 * i)) == (i < 8));
        CHECK(std::isnan(value<double>(frame.fields[4], 3 * i)) == (i >= 8));
    }
}

TEST_CASE("fields: an output field that the scene does not have is refused", "[step]") {
    const auto w = box_world({R"(output={ fields = ["x", "bdy"] })"});
    CHECK(contains(message_of([&] { make_frame(*w, 1, w->scene.output.fields); }), "did you mean 'body'?"));
}
