#include "step/pieces.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <utility>

#include "geometry/random.hpp"
#include "perimpm/error.hpp"

namespace perimpm {

std::vector<std::uint32_t> voronoi_pieces(std::span<const Vec3> X, std::span<const std::size_t> bodies,
                                          const MaterialSpec& material) {
    std::vector<std::uint32_t> piece(X.size());
    std::uint32_t before = 0;
    for (std::size_t body = 0; body + 1 < bodies.size(); ++body) {
        const std::size_t begin = bodies[body], size = bodies[body + 1] - begin;
        if (size < material.pieces)
            throw InputError(material.criterion.source.place.text(),
                             fmt::format("a body of material '{}' has {} particles, which cannot make {} pieces",
                                         material.name, size, material.pieces));
        std::vector<std::size_t> center(size);
        std::iota(center.begin(), center.end(), begin);
        center = Random(material.pieces_seed + body).shuffled(std::move(center));
        center.resize(material.pieces);
        for (std::size_t p = begin; p < begin + size; ++p) {
            const auto nearer = [&](std::size_t a, std::size_t b) {
                return (X[a] - X[p]).squaredNorm() < (X[b] - X[p]).squaredNorm();
            };
            const auto nearest = std::min_element(center.begin(), center.end(), nearer);
            piece[p] = before + static_cast<std::uint32_t>(nearest - center.begin());
        }
        before += material.pieces;
    }
    return piece;
}

}  // namespace perimpm
