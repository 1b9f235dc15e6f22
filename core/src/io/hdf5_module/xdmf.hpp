#pragma once

#include <string>
#include <vector>

#include "frame_file.hpp"

namespace perimpm::hdf5 {

/// XDMF 3 text: the frames, in the order given, as one temporal collection of point clouds.
std::string xdmf_text(const std::vector<FrameInfo>& frames);

}  // namespace perimpm::hdf5
