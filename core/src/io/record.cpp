#include "record.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fstream>

#include "perimpm/error.hpp"

namespace perimpm {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kTotalColumn = 4;
constexpr const char* kEnergyHeader = "time,kinetic,elastic,potential,total,dissipated,px,py,pz,lx,ly,lz\n";

constexpr const char* kFragmentsHeader = "time,fragment,particles,mass,x,y,z,vx,vy,vz\n";

double total_energy(const Ledger& l) { return l.kinetic + l.elastic + l.potential; }

/// Numbers as the shortest text that reads back to the same value. first_total: of the first row [J].
std::string energy_row(const Ledger& l, double first_total) {
    const double total = total_energy(l);
    return fmt::format("{},{},{},{},{},{},{},{}\n", l.time, l.kinetic, l.elastic, l.potential, total,
                       first_total - total, fmt::join(l.momentum, ","), fmt::join(l.angular_momentum, ","));
}

std::string fragment_rows(double time, const std::vector<Fragment>& fragments) {
    std::string rows;
    for (const Fragment& f : fragments)
        rows += fmt::format("{},{},{},{},{},{}\n", time, f.id, f.particles, f.mass, fmt::join(f.center, ","),
                            fmt::join(f.velocity, ","));
    return rows;
}

/// A number of a row; absent when there is none.
std::optional<double> column(const std::string& row, std::size_t index) {
    std::size_t begin = 0;
    for (; index > 0 && begin != std::string::npos; --index) begin = row.find(',', begin) + 1;
    double value = 0;
    const auto [end, error] = std::from_chars(row.data() + begin, row.data() + row.size(), value);
    return error == std::errc() ? std::optional{value} : std::nullopt;
}

/// The rows of a table before `time`, its first column, as they stand in a file with this header; none otherwise.
std::vector<std::string> rows_before(const std::string& path, const std::string& header, double time) {
    std::vector<std::string> rows;
    std::ifstream file(path);
    std::string row;
    if (!std::getline(file, row) || row + "\n" != header) return rows;
    while (std::getline(file, row)) {
        const auto row_time = column(row, 0);
        if (!row_time || *row_time >= time) break;
        rows.push_back(row + "\n");
    }
    return rows;
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
            if (frame_number(name) >= first || name == "failed.h5" || (first == 1 && name == "fragments.csv"))
                fs::remove(entry.path());
        }
    } catch (const fs::filesystem_error& e) {
        throw InputError(folder,
                         "cannot use the output folder: " + e.code().message() + "; choose another one with -o");
    }
}

/// The output frame and, beyond the scene's choice, every other field that all particles have.
Frame whole_state(const Simulation& simulation, std::uint32_t number) {
    std::vector<std::string> names = simulation.scene().output.fields;
    for (const std::string& name : simulation.fields())
        if (std::ranges::count(names, name) == 0) names.push_back(name);
    return simulation.frame(number, names);
}

}  // namespace

RunRecord::RunRecord(const Simulation& simulation, const RunOptions& options, std::uint32_t first)
    : simulation_{simulation}, options_{options}, last_frame_{first - 1} {
    if (silent()) return;
    prepare_folder(options.folder, first);
    keep_tables_before(simulation.time());
    head_ = run_head(simulation, options);
    if (std::ranges::count(simulation.scene().output.formats, "hdf5") > 0) writer_ = make_hdf5_writer(options.folder);
}

void RunRecord::keep_tables_before(double time) {
    energy_ = kEnergyHeader, fragments_ = kFragmentsHeader;
    for (const std::string& row : rows_before(path("energy.csv"), kEnergyHeader, time)) {
        if (!first_total_) first_total_ = column(row, kTotalColumn);
        energy_ += row;
    }
    for (const std::string& row : rows_before(path("fragments.csv"), kFragmentsHeader, time)) fragments_ += row;
}

void RunRecord::frame(std::uint32_t number) {
    last_frame_ = number;
    if (silent()) return;
    if (writer_) writer_->write(simulation_.frame(number));
    const Ledger ledger = simulation_.ledger();
    if (!first_total_) first_total_ = total_energy(ledger);
    energy_ += energy_row(ledger, *first_total_);
    write_text_file(path("energy.csv"), energy_);
    if (simulation_.can_break()) {
        fragments_ += fragment_rows(ledger.time, simulation_.fragments());
        write_text_file(path("fragments.csv"), fragments_);
    }
    status("running");
}

void RunRecord::status(const std::string& status, const std::string& error) {
    if (silent()) return;
    write_text_file(path("run.json"), run_json(head_, simulation_, last_frame_, status, error));
}

void RunRecord::failed(const std::string& error) {
    if (writer_) writer_->write_single(whole_state(simulation_, last_frame_), "failed.h5");
    status("failed", error);
}

}  // namespace perimpm
