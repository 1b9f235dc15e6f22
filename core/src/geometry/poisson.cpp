/*! Maximal Poisson-disk sampling by dart throwing into ever smaller cells.
    Ebeida, Mitchell, Patney, Davidson, Owens 2012, "A simple algorithm for maximal Poisson-disk sampling in high
    dimensions", Computer Graphics Forum 31(2), doi:10.1111/j.1467-8659.2012.03059.x.
      (1) background cells of side r / sqrt(3) hold at most one point each;
      (2) one dart goes into every active cell, in random order; it stays when it is inside the shape and no point is
          nearer than r;
      (3) the active cells without a point are cut into eight; parts that lie wholly within r of one point or wholly
          outside the shape are dropped; then (2) again.
    Differs from the paper: the domain is a signed distance, not a box; one dart per active cell and level; the cells of
    the last level are given up, so that a hole may exceed r by the diagonal of such a cell, r / 2^kLevels. */
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

#include "lattice.hpp"
#include "random.hpp"

namespace perimpm {

namespace {

constexpr int kLevels = 10;      // the last cells have a diagonal of r / 2^10, about a thousandth of r
constexpr std::size_t kPad = 2;  // points nearer than r are at most two background cells away

/// Cell of some level: 2^level of them along each side of a background cell.
using Cell = std::array<std::uint32_t, 3>;

class Sampler {
public:
    Sampler(const Shape& shape, double radius, std::uint64_t seed)
        : shape_(shape),
          radius_(radius),
          lattice_(lattice_over(shape, radius / std::sqrt(3.0), "Poisson-disk cell")),
          random_(seed) {
        for (int axis = 0; axis < 3; ++axis) padded_[axis] = lattice_.count[axis] + 2 * kPad;
        owner_.assign(padded_[0] * padded_[1] * padded_[2], kNone);
        list_neighbours();
    }

    std::vector<Vec3> run() && {
        std::vector<Cell> active = background_cells();
        for (int level = 0; !active.empty(); ++level) {
            for (const Cell& cell : random_.shuffled(active)) throw_dart(cell, level);
            if (level == kLevels) break;
            active = subdivide(active, level);
        }
        return std::move(points_);
    }

private:
    static constexpr std::uint32_t kNone = 0xffffffffu;

    /// Background cells that can hold a point nearer than the radius, as offsets in owner_, nearest first.
    void list_neighbours() {
        std::vector<std::pair<int, std::ptrdiff_t>> found;  // squared gap in cells, offset
        const auto gap = [](int d) { return std::max(std::abs(d) - 1, 0); };
        for (int dz = -2; dz <= 2; ++dz)
            for (int dy = -2; dy <= 2; ++dy)
                for (int dx = -2; dx <= 2; ++dx) {
                    const int squared = gap(dx) * gap(dx) + gap(dy) * gap(dy) + gap(dz) * gap(dz);
                    const auto row = dz * std::ptrdiff_t(padded_[1]) + dy;
                    if (squared < 3) found.emplace_back(squared, row * std::ptrdiff_t(padded_[0]) + dx);
                }
        std::sort(found.begin(), found.end());
        for (const auto& [squared, offset] : found) neighbours_.push_back(offset);
    }

    std::vector<Cell> background_cells() const {
        std::vector<Cell> cells;
        for (std::uint32_t k = 0; k < lattice_.count[2]; ++k)
            for (std::uint32_t j = 0; j < lattice_.count[1]; ++j)
                for (std::uint32_t i = 0; i < lattice_.count[0]; ++i)
                    if (const Cell cell{i, j, k}; !outside(cell, 0)) cells.push_back(cell);
        return cells;
    }

    void throw_dart(const Cell& cell, int level) {
        const Vec3 x = corner(cell, level) + side(level) * Vec3(random_.unit(), random_.unit(), random_.unit());
        const std::size_t home = background(cell, level);
        if (owner_[home] != kNone || shape_.signed_distance(x) >= 0.0 || crowded(x, home)) return;
        owner_[home] = static_cast<std::uint32_t>(points_.size());
        points_.push_back(x);
    }

    /// The parts of one background cell stay together in `active`, so that its surroundings are listed once.
    std::vector<Cell> subdivide(const std::vector<Cell>& active, int level) const {
        std::vector<Cell> parts;
        std::vector<Vec3> around, near;
        std::size_t listed = 0;  // no cell's home: the rim is empty
        for (const Cell& cell : active) {
            const std::size_t home = background(cell, level);
            if (owner_[home] != kNone) continue;
            if (home != std::exchange(listed, home)) list_around(home, around);
            keep_near(cell, level, around, near);
            for (std::uint32_t part = 0; part < 8; ++part) {
                const Cell child{2 * cell[0] + (part & 1), 2 * cell[1] + (part >> 1 & 1), 2 * cell[2] + (part >> 2)};
                if (!covered(child, level + 1, near) && !outside(child, level + 1)) parts.push_back(child);
            }
        }
        return parts;
    }

    bool crowded(const Vec3& x, std::size_t home) const {
        return std::any_of(neighbours_.begin(), neighbours_.end(), [&](std::ptrdiff_t offset) {
            const std::uint32_t point = owner_[home + std::size_t(offset)];
            return point != kNone && (points_[point] - x).squaredNorm() < radius_ * radius_;
        });
    }

    void list_around(std::size_t home, std::vector<Vec3>& around) const {
        around.clear();
        for (const std::ptrdiff_t offset : neighbours_)
            if (const auto point = owner_[home + std::size_t(offset)]; point != kNone) around.push_back(points_[point]);
    }

    /// Points that can reach the centre of a part of the cell, which is what covering the part takes.
    void keep_near(const Cell& cell, int level, const std::vector<Vec3>& around, std::vector<Vec3>& near) const {
        const Vec3 center = corner(cell, level) + Vec3::Constant(0.5 * side(level));
        const double reach = radius_ + 0.25 * std::sqrt(3.0) * side(level);
        near.clear();
        for (const Vec3& p : around)
            if ((p - center).squaredNorm() < reach * reach) near.push_back(p);
    }

    /// One point has the whole cell, up to its farthest corner, within the radius.
    bool covered(const Cell& cell, int level, const std::vector<Vec3>& near) const {
        const Vec3 half = Vec3::Constant(0.5 * side(level));
        const Vec3 center = corner(cell, level) + half;
        return std::any_of(near.begin(), near.end(), [&](const Vec3& p) {
            return ((p - center).cwiseAbs() + half).squaredNorm() < radius_ * radius_;
        });
    }

    bool outside(const Cell& cell, int level) const {
        const double half = 0.5 * side(level);
        return shape_.signed_distance(corner(cell, level) + Vec3::Constant(half)) > std::sqrt(3.0) * half;
    }

    double side(int level) const { return lattice_.spacing / (1u << level); }

    Vec3 corner(const Cell& cell, int level) const {
        return lattice_.origin + side(level) * Vec3(cell[0], cell[1], cell[2]);
    }

    /// Index in owner_ of the background cell that holds `cell`.
    std::size_t background(const Cell& cell, int level) const {
        const std::size_t i = (cell[0] >> level) + kPad, j = (cell[1] >> level) + kPad, k = (cell[2] >> level) + kPad;
        return (k * padded_[1] + j) * padded_[0] + i;
    }

    const Shape& shape_;
    double radius_;
    Lattice lattice_;
    Random random_;
    std::array<std::size_t, 3> padded_{};  // background cells with a rim that stays empty
    std::vector<std::uint32_t> owner_;     // point in each background cell
    std::vector<std::ptrdiff_t> neighbours_;
    std::vector<Vec3> points_;
};

}  // namespace

std::vector<Vec3> sample_poisson(const Shape& shape, double radius, std::uint64_t seed) {
    return Sampler(shape, radius, seed).run();
}

}  // namespace perimpm
