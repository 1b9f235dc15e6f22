#pragma once

#include <string>
#include <vector>

#include "perimpm/scene/scene.hpp"
#include "state/images.hpp"

namespace perimpm {

/// Which faces of the domain act by images.
DomainImages find_images(const GridSpec& grid);
/// Whether nodes on and behind face `f` are set one by one instead.
inline bool sets_nodes(const GridSpec& grid, const DomainImages& images, int f) {
    const AxisImages& axis = images.axis[f / 2];
    return grid.faces[f] != Face::open && axis.period == 0 && !(f % 2 ? axis.high : axis.low).mirrors;
}
/// One message for every slip or sticky face that is no mirror because of where it lies.
std::vector<std::string> inexact_faces(const GridSpec& grid, const DomainImages& images);

}  // namespace perimpm
