#include "state/kept_rows.hpp"
#include "support/catch.hpp"

using namespace perimpm;

TEST_CASE("kept rows: rows of the same bits are kept once", "[state]") {
    Rows<double> rows;
    CHECK(rows.keep({1.0, 2.0}) == 0);
    CHECK(rows.keep({2.0, 1.0}) == 2);
    CHECK(rows.keep({1.0, 2.0}) == 0);
    CHECK(rows.keep({1.0}) == 4);
    CHECK(rows.keep({0.0}) == 5);
    CHECK(rows.keep({-0.0}) == 6);
    CHECK(rows.items.size() == 7);
}

TEST_CASE("kept rows: rows of the same hash are told apart", "[state]") {
    KeptRows kept;
    const auto never = [](std::size_t) { return false; };
    CHECK(kept.find(7, 2, 0, never) == 0);
    CHECK(kept.find(7, 2, 2, never) == 2);
    CHECK(kept.find(7, 3, 4, [](std::size_t) { return true; }) == 4);
    CHECK(kept.find(7, 2, 7, [](std::size_t first) { return first == 2; }) == 2);
    CHECK(kept.rows.size() == 3);
}
