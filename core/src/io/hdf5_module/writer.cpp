#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <map>

#include "frame_file.hpp"
#include "handle.hpp"
#include "perimpm/export.hpp"
#include "xdmf.hpp"

namespace perimpm::hdf5 {
namespace {

namespace fs = std::filesystem;

std::string frame_name(std::uint32_t number) {
    char text[32];
    std::snprintf(text, sizeof text, "frame.%04u.h5", number);
    return text;
}

class Hdf5Writer final : public FrameWriter {
public:
    explicit Hdf5Writer(std::string folder) : folder_{std::move(folder)} {
        H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
        std::error_code error;
        for (const auto& entry : fs::directory_iterator(folder_, error)) {
            const std::string name = entry.path().filename().string();
            if (name.starts_with("frame.") && name.ends_with(".h5"))
                series_.emplace(name, read_frame_info(entry.path().string()));
        }
        if (error) throw InputError(folder_, "cannot use the output folder: " + error.message());
    }

    void write(const Frame& frame) override {
        const std::string name = frame_name(frame.number);
        write_single(frame, name);
        series_.insert_or_assign(name, read_frame_info(folder_ + "/" + name));
        write_text_file(folder_ + "/run.xdmf", xdmf_text(in_time_order()));
    }

    void write_single(const Frame& frame, const std::string& file_name) override {
        write_frame_file(folder_ + "/" + file_name, frame);
    }

private:
    std::vector<FrameInfo> in_time_order() const {
        std::vector<FrameInfo> frames;
        for (const auto& [name, info] : series_) frames.push_back(info);
        std::ranges::stable_sort(frames, {}, &FrameInfo::time);
        return frames;
    }

    std::string folder_;
    std::map<std::string, FrameInfo> series_;  ///< by file name
};

}  // namespace
}  // namespace perimpm::hdf5

extern "C" PERIMPM_API const char* perimpm_module_versions() {
    static const std::string text = [] {
        unsigned major = 0, minor = 0, release = 0;
        H5get_libversion(&major, &minor, &release);
        return "HDF5 " + std::to_string(major) + "." + std::to_string(minor) + "." + std::to_string(release);
    }();
    return text.c_str();
}

extern "C" PERIMPM_API perimpm::FrameWriter* perimpm_make_hdf5_writer(const char* folder) {
    return new perimpm::hdf5::Hdf5Writer(folder);
}
