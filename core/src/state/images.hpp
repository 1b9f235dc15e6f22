#pragma once

#include <cstdint>

namespace perimpm {

/// How far behind a face nodes are looked after [cells]: particles may get two cells behind it, and their stencils reach two
/// cells farther.
inline constexpr std::int32_t kImageReach = 4;

/// The node inside that a node behind a face is the image of.
struct ImageOf {
    std::int32_t node;
    std::uint8_t flip = 0;  ///< bits of the components that change sign on the way
    std::uint8_t zero = 0;  ///< bits of the components that vanish: those that flip on the face itself
};

/// The faces of one axis. Positions in half cells, as faces lie on nodes or midway between two.
struct AxisImages {
    struct End {
        bool mirrors = false;
        std::int32_t at = 0;    ///< [dx / 2]
        std::uint8_t flip = 0;  ///< bits of the components that a reflection reverses
    };
    End low = {}, high = {};
    std::int32_t period = 0;  ///< [dx]; 0: not periodic. Nodes from ceil(low.at / 2) on are the ones inside.

    bool any() const { return period > 0 || low.mirrors || high.mirrors; }
    std::int32_t first_inside() const { return low.at >= 0 ? (low.at + 1) / 2 : low.at / 2; }
    /// False for nodes farther behind a face than any particle reaches.
    bool within_reach(std::int32_t i) const {
        if (period > 0) return i >= first_inside() - kImageReach && i < first_inside() + period + kImageReach;
        return (!low.mirrors || 2 * i >= low.at - 2 * kImageReach) &&
               (!high.mirrors || 2 * i <= high.at + 2 * kImageReach);
    }
    ImageOf operator()(std::int32_t i) const {
        ImageOf image{i};
        if (period > 0) {
            const std::int32_t offset = (i - first_inside()) % period;
            image.node = first_inside() + (offset < 0 ? offset + period : offset);
            return image;
        }
        for (;;) {  // between two mirrors a node may be the image of an image
            if (low.mirrors && 2 * image.node < low.at)
                image.node = low.at - image.node, image.flip ^= low.flip;
            else if (high.mirrors && 2 * image.node > high.at)
                image.node = high.at - image.node, image.flip ^= high.flip;
            else
                break;
        }
        if (low.mirrors && 2 * image.node == low.at) image.zero |= low.flip;
        if (high.mirrors && 2 * image.node == high.at) image.zero |= high.flip;
        return image;
    }
};

/// Mirrors and periodic borders of the domain, by axis.
struct DomainImages {
    AxisImages axis[3];
    bool any() const { return axis[0].any() || axis[1].any() || axis[2].any(); }
    bool periodic() const { return axis[0].period > 0 || axis[1].period > 0 || axis[2].period > 0; }
};

/// A node behind a face (or on it, then `node` equals `of`) and the node inside whose image it is; both counted over all
/// blocks of the grid.
struct NodeImage {
    std::uint32_t of, node;
    std::uint8_t flip, zero;
};

}  // namespace perimpm
