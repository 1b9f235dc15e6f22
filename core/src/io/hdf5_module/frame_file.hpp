#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "perimpm/io/frame_writer.hpp"

namespace perimpm::hdf5 {

/// What a frame file holds, without the numbers.
struct FrameInfo {
    struct Field {
        std::string name, type;  ///< type: "Float" or "UInt", as XDMF has it
        std::uint64_t components;
        std::uint64_t bytes;  ///< of one number
    };
    std::string file;  ///< name inside the folder
    double time;       ///< [s]
    std::uint64_t rows;
    std::vector<Field> fields;
};

/// Writes one frame aside and renames it to `path`. Throws InputError.
void write_frame_file(const std::string& path, const Frame& frame);

/// Reads the description of a frame file. Throws InputError.
FrameInfo read_frame_info(const std::string& path);

}  // namespace perimpm::hdf5
