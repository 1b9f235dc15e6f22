#include <cstdint>
#include <utility>

#include "state/array.hpp"
#include "support/catch.hpp"

using namespace perimpm;

namespace {

bool on_boundary(const void* address) { return reinterpret_cast<std::uintptr_t>(address) % 64 == 0; }

}  // namespace

TEMPLATE_TEST_CASE("array: zero, on a 64-byte boundary, of any size", "[state]", float, double, std::uint32_t) {
    for (const std::size_t size : {1, 3, 16, 1000}) {
        AlignedArray<TestType> array(size);
        CHECK(on_boundary(array.data()));
        CHECK(array.size() == size);
        CHECK(array.bytes() == size * sizeof(TestType));
        for (std::size_t i = 0; i < size; ++i) CHECK(array[i] == TestType(0));
    }
}

TEST_CASE("array: an empty one has no memory", "[state]") {
    CHECK(AlignedArray<float>().empty());
    CHECK(AlignedArray<float>(0).data() == nullptr);
    CHECK(FieldArray<double>().empty());
    CHECK(FieldArray<double>(0, 3).bytes() == 0);
}

TEST_CASE("array: moving keeps the memory", "[state]") {
    AlignedArray<double> from(5);
    from[4] = 7;
    const double* address = from.data();
    const AlignedArray<double> to = std::move(from);
    CHECK(to.data() == address);
    CHECK(to[4] == 7);
}

TEST_CASE("array: a field's components start on boundaries, without holes between entries", "[state]") {
    FieldArray<float> field(17, 3);
    CHECK(field.components() == 3);
    const Field<float> view = field.view();
    CHECK(view.stride == 32);  // 17 floats are two lines of 16
    CHECK(field.bytes() == 3 * 32 * sizeof(float));
    for (std::size_t c = 0; c < 3; ++c) {
        CHECK(on_boundary(field[c]));
        CHECK(view[c] == field[c]);
        CHECK(&field[c][16] == field[c] + 16);
    }
    CHECK(view.from(5)[2] == field[2] + 5);
    CHECK_FALSE(static_cast<bool>(Field<float>{}.from(5)));
}
