#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "perimpm/export.hpp"

namespace perimpm {

/// What the numbers of a field are.
enum class NumberType { float32, float64, uint32 };
constexpr std::size_t bytes_of(NumberType type) { return type == NumberType::float64 ? 8 : 4; }

/// One field of a frame, rows in the order of particle ids.
struct FrameField {
    std::string name;
    std::string unit;
    std::string source;        ///< who computes it: "core", or the model, e.g. "apic" or "pd_elastic"
    std::uint32_t components;  ///< 1, 3 or 9
    NumberType type;
    std::vector<std::byte> data;  ///< rows x components
};

struct Frame {
    std::uint32_t number;  ///< 1 is t = 0
    double time;           ///< [s]
    std::uint64_t step;
    std::uint64_t rows;
    std::vector<FrameField> fields;  ///< "x" among them
};

/// Writes frames of one run into a folder; a file is complete or absent (written aside, then renamed).
class PERIMPM_API FrameWriter {
public:
    virtual ~FrameWriter();
    /// The next frame of the series, `frame.<number>`.
    virtual void write(const Frame& frame) = 0;
    /// One file of the given name outside the series, e.g. "failed.h5".
    virtual void write_single(const Frame& frame, const std::string& file_name) = 0;
};

/// HDF5 frames `frame.0001.h5 ...` with `run.xdmf` (a time series that ParaView opens) kept up to date after every
/// frame; it lists every frame in the folder, also those of an earlier run that is continued. Opens the hdf5 module.
/// Throws InputError when the folder cannot be written.
PERIMPM_API std::unique_ptr<FrameWriter> make_hdf5_writer(const std::string& folder);

/// Writes text aside and renames it over `path`. Throws InputError when that fails.
PERIMPM_API void write_text_file(const std::string& path, const std::string& text);

}  // namespace perimpm
