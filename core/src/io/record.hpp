#pragma once

#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "perimpm/io/run.hpp"

namespace perimpm {

/// Keeps the files of one run up to date: frames, energy.csv, fragments.csv where bonds can break, run.json. Without a folder it writes nothing.
class RunRecord {
public:
    /// Makes the folder and removes what a former run left there from frame `first` on. Throws InputError.
    RunRecord(const Simulation& simulation, const RunOptions& options, std::uint32_t first);

    void frame(std::uint32_t number);
    /// status: "running", "done", "stopped" or "failed" (with the reason).
    void status(const std::string& status, const std::string& error = "");
    /// Dumps every field of all particles to failed.h5 and says so in run.json.
    void failed(const std::string& error);

private:
    bool silent() const { return options_.folder.empty(); }
    /// Takes over the rows of the tables before `time`, so that a continued run keeps them.
    void keep_tables_before(double time);
    std::string path(const char* name) const { return options_.folder + "/" + name; }

    const Simulation& simulation_;
    const RunOptions& options_;
    std::uint32_t last_frame_ = 0;
    std::string energy_, fragments_;     ///< energy.csv and fragments.csv so far
    std::optional<double> first_total_;  ///< total energy of its first row [J]
    nlohmann::ordered_json head_;        ///< what run.json says from start to end
    std::unique_ptr<FrameWriter> writer_;
};

/// The lasting part of run.json: versions, seeds, sizes, the resolved scene.
nlohmann::ordered_json run_head(const Simulation& simulation, const RunOptions& options);
/// run.json: how far the run is and the time of every pass, then the lasting part.
std::string run_json(const nlohmann::ordered_json& head, const Simulation& simulation, std::uint32_t last_frame,
                     const std::string& status, const std::string& error);

}  // namespace perimpm
