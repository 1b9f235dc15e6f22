#include "state/bonds.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "perimpm/error.hpp"

namespace perimpm {

namespace {

/// Neighbours on the rim belong to the family, whatever the last digits of their positions are.
constexpr double kRim = 1 + 1e-9;

/// Particles of one body in cells as wide as the horizon; neighbours lie in the 27 cells around.
class CellList {
public:
    CellList(std::span<const Vec3> X, std::size_t begin, std::size_t end, double width) : X_{X}, width_{width} {
        Box3 box;
        for (std::size_t p = begin; p < end; ++p) box.extend(X[p]);
        origin_ = box.min();
        for (int c = 0; c < 3; ++c) cells_[c] = static_cast<std::int64_t>(box.sizes()[c] / width_) + 1;
        order_.reserve(end - begin);
        for (std::size_t p = begin; p < end; ++p) order_.push_back({key(cell(X[p])), static_cast<std::uint32_t>(p)});
        std::sort(order_.begin(), order_.end());
    }

    /// Particles within `horizon` of particle p, without p, ascending; into `found`.
    void neighbours(std::uint32_t p, double horizon, std::vector<std::uint32_t>& found) const {
        found.clear();
        const auto home = cell(X_[p]);
        for (std::int64_t i = home[0] - 1; i <= home[0] + 1; ++i)
            for (std::int64_t j = home[1] - 1; j <= home[1] + 1; ++j) {
                if (i < 0 || j < 0 || i >= cells_[0] || j >= cells_[1]) continue;
                const std::int64_t low = std::max<std::int64_t>(home[2] - 1, 0),
                                   high = std::min(home[2] + 1, cells_[2] - 1);
                auto it = std::lower_bound(order_.begin(), order_.end(), Entry{key({i, j, low}), 0});
                for (; it != order_.end() && it->key <= key({i, j, high}); ++it)
                    if (it->particle != p && (X_[it->particle] - X_[p]).norm() <= kRim * horizon)
                        found.push_back(it->particle);
            }
        std::sort(found.begin(), found.end());
    }

private:
    using Cell = std::array<std::int64_t, 3>;
    struct Entry {
        std::int64_t key;
        std::uint32_t particle;
        friend auto operator<=>(const Entry&, const Entry&) = default;
    };
    Cell cell(const Vec3& x) const {
        Cell c;
        for (int a = 0; a < 3; ++a) c[a] = static_cast<std::int64_t>((x[a] - origin_[a]) / width_);
        return c;
    }
    std::int64_t key(const Cell& c) const { return (c[0] * cells_[1] + c[1]) * cells_[2] + c[2]; }

    std::span<const Vec3> X_;
    double width_;
    Vec3 origin_;
    Cell cells_;
    std::vector<Entry> order_;
};

}  // namespace

std::uint32_t Bonds::opposite(std::uint32_t particle, std::uint32_t slot) const {
    const std::uint32_t q = neighbour[slot];
    const std::uint32_t* begin = neighbour.data() + row[q];
    return static_cast<std::uint32_t>(std::lower_bound(begin, neighbour.data() + row[q + 1], particle) -
                                      neighbour.data());
}

bool Bonds::break_direction(std::uint32_t particle, std::uint32_t slot) {
    std::uint64_t& word = broken[slot >> 6];
    const std::uint64_t bit = std::uint64_t{1} << (slot & 63);
    if (word & bit) return false;
    word |= bit;
    is_cut = true;
    ++damage[particle];
    share[particle] = static_cast<float>(damage[particle]) / static_cast<float>(row[particle + 1] - row[particle]);
    return true;
}

Bonds build_bonds(std::span<const Vec3> X, std::span<const std::size_t> bodies, double horizon, bool can_break) {
    std::vector<std::uint32_t> all, family;
    Bonds bonds;
    bonds.row = AlignedArray<std::uint32_t>(X.size() + 1);
    for (std::size_t body = 0; body + 1 < bodies.size(); ++body) {
        const CellList cells(X, bodies[body], bodies[body + 1], kRim * horizon);
        for (std::size_t p = bodies[body]; p < bodies[body + 1]; ++p) {
            cells.neighbours(static_cast<std::uint32_t>(p), horizon, family);
            for (const std::uint32_t q : family)
                if ((X[q] - X[p]).norm() <= 1e-9 * horizon)
                    throw InputError(fmt::format(
                        "two particles of one body share the place ({:g}, {:g}, {:g}) m: a bond needs a length",
                        X[p][0], X[p][1], X[p][2]));
            if (all.size() + family.size() >= std::numeric_limits<std::uint32_t>::max())
                throw InputError("more than 2^32 - 1 bonds in one material: use a smaller horizon or fewer particles");
            all.insert(all.end(), family.begin(), family.end());
            bonds.row[p + 1] = static_cast<std::uint32_t>(all.size());
        }
    }
    bonds.neighbour = AlignedArray<std::uint32_t>(all.size(), kSlotPadding);
    std::copy(all.begin(), all.end(), bonds.neighbour.data());
    if (can_break) {
        bonds.broken = AlignedArray<std::uint64_t>(all.size() / 64 + 2);
        bonds.damage = AlignedArray<std::uint32_t>(X.size());
        bonds.share = AlignedArray<float>(X.size());
    }
    return bonds;
}

}  // namespace perimpm
