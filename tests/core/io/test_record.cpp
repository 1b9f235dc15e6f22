#include <algorithm>

#include "io/record.hpp"
#include "support/box_scene.hpp"
#include "support/catch.hpp"
#include "support/environment.hpp"
#include "support/files.hpp"
#include "support/message.hpp"
#include "support/scene.hpp"

using namespace perimpm;
namespace fs = std::filesystem;

namespace {

const std::string kHeader = "time,kinetic,elastic,potential,total,dissipated,px,py,pz,lx,ly,lz\n";
const std::string kFiles = R"(output={ formats = ["hdf5"], fields = ["x"] })";

std::ptrdiff_t lines(const std::string& text) { return std::count(text.begin(), text.end(), '\n'); }

}  // namespace

TEST_CASE("record: every frame leaves a file, an energy row and the state of the run", "[io]") {
    const TemporaryFolder folder;
    const Simulation simulation(scene_from(kBox, {kFiles, "body.0.initial_velocity=[1, 0, 0]"}), 1);
    const RunOptions options{.folder = folder.path / "out", .after_step = {}};
    RunRecord record(simulation, options, 1);
    record.frame(1);
    CHECK(files_in(options.folder) == std::set<std::string>{"frame.0001.h5", "run.xdmf", "run.json", "energy.csv"});
    const std::string energy = text_of(options.folder + "/energy.csv");
    const std::string start = kHeader + "0,";
    REQUIRE(energy.starts_with(start));
    CHECK(std::stod(energy.substr(start.size())) == Approx(32));  // 64 kg at 1 m/s
    CHECK(contains(text_of(options.folder + "/run.json"), R"("status": "running")"));
    record.status("done");
    CHECK(contains(text_of(options.folder + "/run.json"), R"("status": "done")"));
}

TEST_CASE("record: what a former run left from the first frame on is removed, nothing else", "[io]") {
    const TemporaryFolder folder;
    for (const char* name :
         {"frame.0001.h5", "frame.0002.h5", "frame.0003.h5", "failed.h5", "frame.two.h5", "notes.txt"})
        std::ofstream(folder.path / name) << "old";
    std::ofstream(folder.path / "energy.csv") << kHeader << "-2,1,2,4,7,0,a\n-1,1,2,3,6,1,b\n0,c\n1,d\n";
    const Simulation simulation(scene_from(kBox, {"output={ formats = [] }"}), 1);
    const RunOptions options{.folder = folder.path, .after_step = {}};
    RunRecord record(simulation, options, 2);
    CHECK(files_in(folder.path) == std::set<std::string>{"frame.0001.h5", "frame.two.h5", "notes.txt", "energy.csv"});
    record.frame(2);
    const std::string energy = text_of(folder.path / "energy.csv");
    CHECK(lines(energy) == 4);                                  // header, -2, -1 and the new one
    CHECK(contains(energy, "\n-1,1,2,3,6,1,b\n0,0,0,0,0,7,"));  // at rest: all 7 J of the first row are gone
}

TEST_CASE("record: energies of another layout are not continued", "[io]") {
    const TemporaryFolder folder;
    std::ofstream(folder.path / "energy.csv") << "time,rest\n-2,a\n-1,b\n";
    const Simulation simulation(scene_from(kBox, {"output={ formats = [] }"}), 1);
    const RunOptions options{.folder = folder.path, .after_step = {}};
    RunRecord record(simulation, options, 2);
    record.frame(2);
    const std::string energy = text_of(folder.path / "energy.csv");
    CHECK(energy.starts_with(kHeader + "0,"));
    CHECK(lines(energy) == 2);
}

TEST_CASE("record: a failure dumps every field, whatever the scene puts out", "[io]") {
    const TemporaryFolder folder;
    const Simulation simulation(scene_from(kBox, {kFiles}), 1);
    const RunOptions options{.folder = folder.path, .after_step = {}};
    RunRecord record(simulation, options, 1);
    record.failed("something broke");
    CHECK(contains(text_of(folder.path / "run.json"), R"("error": "something broke")"));
    const std::string dump = text_of(folder.path / "failed.h5");
    for (const char* name : {"mass", "volume"}) CHECK(contains(dump, name));
}

TEST_CASE("record: without a folder nothing is written", "[io]") {
    const TemporaryFolder folder;
    const Simulation simulation(scene_from(kBox, {kFiles}), 1);
    const fs::path before = fs::current_path();
    fs::current_path(folder.path);
    const RunOptions options;
    RunRecord record(simulation, options, 1);
    record.frame(1), record.status("done"), record.failed("x");
    fs::current_path(before);
    CHECK(files_in(folder.path).empty());
}

TEST_CASE("record: a folder that cannot be made is named with a remedy", "[io]") {
    const TemporaryFolder folder;
    std::ofstream(folder.path / "file") << "in the way";
    const Simulation simulation(scene_from(kBox), 1);
    const RunOptions options{.folder = folder.path / "file/out", .after_step = {}};
    CHECK(contains(message_of([&] { RunRecord(simulation, options, 1); }), "choose another one with -o"));
}
