#include "perimpm/io/frame_writer.hpp"
#include "perimpm/plugin/registry.hpp"

namespace perimpm {

FrameWriter::~FrameWriter() = default;

std::unique_ptr<FrameWriter> make_hdf5_writer(const std::string& folder) {
    using Factory = FrameWriter*(const char* folder);
    auto* factory = reinterpret_cast<Factory*>(open_module("hdf5", "perimpm_make_hdf5_writer"));
    return std::unique_ptr<FrameWriter>(factory(folder.c_str()));
}

}  // namespace perimpm
