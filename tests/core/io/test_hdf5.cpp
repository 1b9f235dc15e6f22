// The files' contents are read back in tests/python/test_output.py; here: which files there are, and when.
#include <cstring>

#include "perimpm/io/frame_writer.hpp"
#include "support/catch.hpp"
#include "support/environment.hpp"
#include "support/files.hpp"
#include "support/message.hpp"

using namespace perimpm;

namespace {

Frame frame(std::uint32_t number, double time) {
    FrameField x{"x", "m", "core", 3, NumberType::float32, std::vector<std::byte>(2 * 3 * 4)};
    const float places[6] = {1, 2, 3, 4, 5, 6};
    std::memcpy(x.data.data(), places, sizeof places);
    return {number, time, 10, 2, {x}};
}

}  // namespace

TEST_CASE("hdf5: frames are whole files of their number, listed in order of time", "[io]") {
    const TemporaryFolder folder;
    const auto writer = make_hdf5_writer(folder.path);
    writer->write(frame(2, 0.5));
    writer->write(frame(1, 0.25));
    writer->write_single(frame(3, 0.75), "failed.h5");
    CHECK(files_in(folder.path) == std::set<std::string>{"frame.0001.h5", "frame.0002.h5", "failed.h5", "run.xdmf"});
    CHECK(text_of(folder.path / "frame.0001.h5").substr(1, 3) == "HDF");
    const std::string series = text_of(folder.path / "run.xdmf");
    CHECK(series.find("frame.0001.h5") < series.find("frame.0002.h5"));
    CHECK(series.find("frame.0002.h5") != std::string::npos);
    CHECK_FALSE(contains(series, "failed.h5"));
}

TEST_CASE("hdf5: a continued series keeps the frames that the folder holds", "[io]") {
    const TemporaryFolder folder;
    make_hdf5_writer(folder.path)->write(frame(1, 0.25));
    make_hdf5_writer(folder.path)->write(frame(2, 0.5));
    const std::string series = text_of(folder.path / "run.xdmf");
    CHECK(contains(series, "frame.0001.h5"));
    CHECK(contains(series, "frame.0002.h5"));
}

TEST_CASE("hdf5: a folder that cannot be used is named", "[io]") {
    CHECK(contains(message_of([] { make_hdf5_writer("/no/such/folder"); }), "/no/such/folder: error: "));
}
