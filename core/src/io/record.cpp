#include "record.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "perimpm/error.hpp"

namespace perimpm {
namespace {

namespace fs = std::filesystem;

constexpr const char* kEnergyHeader = "time,kinetic,elastic,potential,total,px,py,pz,lx,ly,lz\n";

/// Numbers as the shortest text that reads back to the same value.
std::string energy_row(const Ledger& l) {
    const double total = l.kinetic + l.elastic + l.potential;
    return fmt::format("{},{},{},{},{},{},{}\n", l.time, l.kinetic, l.elastic, l.potential, total,
                       fmt::join(l.momentum, ","), fmt::join(l.angular_momentum, ","));
}

/// The rows of an energy.csv written before `time`, so that a continued run keeps them.
std::string energy_before(const std::string& path, double time) {
    std::string kept = kEnergyHeader;
    std::ifstream file(path);
    std::string line;
    std::getline(file, line);
    while (std::getline(file, line)) {
        double row_time = 0;
        const auto [end, error] = std::from_chars(line.data(), line.data() + line.size(), row_time);
        if (error != std::errc() || row_time >= time) break;
        kept += line + "\n";
    }
    return kept;
}

/// Number of a file "frame.<digits>.h5", 0 for any other name.
std::uint32_t frame_number(const std::string& name) {
    if (!name.starts_with("frame.") || !name.ends_with(".h5") || name.size() < 10) return 0;
    std::uint32_t number = 0;
    const char* last = name.data() + name.size() - 3;
    const auto [end, error] = std::from_chars(name.data() + 6, last, number);
    return error == std::errc() && end == last ? number : 0;
}

void prepare_folder(const std::string& folder, std::uint32_t first) {
    try {
        fs::create_directories(folder);
        for (const auto& entry : fs::directory_iterator(folder)) {
            const std::string name = entry.path().filename().string();
            if (frame_number(name) >= first || name == "failed.h5") fs::remove(entry.path());
        }
    } catch (const fs::filesystem_error& e) {
        throw InputError(folder,
                         "cannot use the output folder: " + e.code().message() + "; choose another one with -o");
    }
}

FrameField::Type frame_type(FieldView::Type type) {
    switch (type) {
        case FieldView::Type::float32:
            return FrameField::Type::float32;
        case FieldView::Type::float64:
            return FrameField::Type::float64;
        case FieldView::Type::uint32:
            break;
    }
    return FrameField::Type::uint32;
}

/// Rows of a field in the order of `ids` (slot i holds particle ids[i]).
FrameField copy_field(const FieldView& view, const std::uint32_t* ids) {
    const std::size_t width = view.type == FieldView::Type::float64 ? 8 : 4;
    FrameField field{view.name,
                     view.unit,
                     "core",
                     static_cast<std::uint32_t>(view.components),
                     frame_type(view.type),
                     std::vector<std::byte>(view.size * view.components * width)};
    const auto* from = static_cast<const std::byte*>(view.data);
    for (std::size_t i = 0; i < view.size; ++i)
        for (std::size_t c = 0; c < view.components; ++c)
            std::memcpy(field.data.data() + (ids[i] * view.components + c) * width,
                        from + (c * view.stride + i) * width, width);
    return field;
}

/// The output frame and, beyond the scene's choice, every other field that all particles have.
Frame whole_state(const Simulation& simulation, std::uint32_t number) {
    Frame frame = simulation.frame(number);
    const auto* ids = static_cast<const std::uint32_t*>(simulation.field("id").data);
    for (const std::string& name : simulation.fields()) {
        const bool present = std::ranges::any_of(frame.fields, [&](const FrameField& f) { return f.name == name; });
        if (!present) frame.fields.push_back(copy_field(simulation.field(name), ids));
    }
    return frame;
}

}  // namespace

RunRecord::RunRecord(const Simulation& simulation, const RunOptions& options, std::uint32_t first)
    : simulation_{simulation}, options_{options}, last_frame_{first - 1} {
    if (silent()) return;
    prepare_folder(options.folder, first);
    energy_ = energy_before(path("energy.csv"), simulation.time());
    if (std::ranges::count(simulation.scene().output.formats, "hdf5") > 0) writer_ = make_hdf5_writer(options.folder);
}

void RunRecord::frame(std::uint32_t number) {
    last_frame_ = number;
    if (silent()) return;
    if (writer_) writer_->write(simulation_.frame(number));
    energy_ += energy_row(simulation_.ledger());
    write_text_file(path("energy.csv"), energy_);
    status("running");
}

void RunRecord::status(const std::string& status, const std::string& error) {
    if (silent()) return;
    write_text_file(path("run.json"), run_json(simulation_, options_, last_frame_, status, error));
}

void RunRecord::failed(const std::string& error) {
    if (writer_) writer_->write_single(whole_state(simulation_, last_frame_), "failed.h5");
    status("failed", error);
}

}  // namespace perimpm
