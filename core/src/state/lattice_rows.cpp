#include "state/lattice_rows.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <type_traits>

#include "state/kept_rows.hpp"

namespace perimpm {

namespace {

static_assert(std::has_unique_object_representations_v<RowNeighbour<std::int32_t>> &&
              std::has_unique_object_representations_v<RowNeighbour<std::int64_t>>);  // bits are compared: no holes

/// Particles side by side in memory, each one step further along an axis than the one before.
template <class Real>
struct Run {
    std::uint32_t first, size, axis;
    Real step;
};

/// What the particles of a run see of another one, or of their own.
template <class Real>
struct Seen {
    std::uint32_t run;
    std::int32_t offset;  ///< in memory, to the particle at the same place
    std::int32_t begin;   ///< place of the other run's first particle
    Real across[2];
    std::vector<Real> weight{};  ///< w V by distance along the run; NaN where no bond is
    std::int64_t bonds = 0;

    std::int32_t reach() const { return static_cast<std::int32_t>(weight.size()) - 1; }
};

template <class Real>
class RowFinder {
public:
    RowFinder(const Bonds& bonds, const Real* reference, const std::uint32_t* shape, const Real* shared)
        : bonds_{bonds}, reference_{reference}, shape_{shape}, shared_{shared}, run_of_(bonds.row.size() - 1) {
        find_runs();
    }

    BondRows<Real> operator()(std::uint32_t shortest, double least_reach) {
        std::vector<LatticeRow> rows;
        for (const Run<Real>& run : runs_) {
            if (run.size < shortest || !look_around(run)) continue;
            const std::vector<RowNeighbour<Real>> neighbours = neighbours_of(run);
            LatticeRow row{.first = run.first, .size = run.size, .axis = run.axis};
            row.end = row.whole_end = static_cast<std::int32_t>(run.size);
            double reaching = 0, reach = 0;
            for (const RowNeighbour<Real>& n : neighbours) {
                if (n.reach == 0) continue;
                reaching += 1, reach += n.reach;
                row.begin = std::min(row.begin, n.begin), row.end = std::max(row.end, n.end);
                row.whole_begin = std::max(row.whole_begin, n.begin), row.whole_end = std::min(row.whole_end, n.end);
            }
            if (reaching == 0 || reach < least_reach * reaching) continue;
            row.neighbours = static_cast<std::uint32_t>(kept_.keep(neighbours));
            row.count = static_cast<std::uint32_t>(neighbours.size());
            rows.push_back(row);
        }
        return {aligned(rows), aligned(kept_.items)};
    }

private:
    static constexpr auto kMostReach = static_cast<std::int32_t>(RowNeighbour<Real>::kMostReach);

    const Real* at(std::size_t particle) const { return reference_ + 4 * particle; }

    /// The axis along which alone the next particle is further on; 3: there is none.
    std::uint32_t axis_to_next(std::size_t p) const {
        std::uint32_t found = 3;
        for (std::uint32_t c = 0; c < 3; ++c) {
            if (at(p + 1)[c] == at(p)[c]) continue;
            if (found < 3 || at(p + 1)[c] < at(p)[c]) return 3;
            found = c;
        }
        return found;
    }

    Real step_to_next(std::size_t p, std::uint32_t axis) const { return at(p + 1)[axis] - at(p)[axis]; }

    /// A single particle, also one before a gap, has the axis and the step of the run before.
    void find_runs() {
        Run<Real> run{0, 0, 3, Real(0)};
        const std::size_t size = run_of_.size();
        for (std::size_t p = 0; p < size; p = run.first + run.size) {
            run.first = static_cast<std::uint32_t>(p), run.size = 1;
            const std::uint32_t axis = p + 1 < size ? axis_to_next(p) : 3;
            if (axis < 3) {
                const Real step = step_to_next(p, axis);
                const bool repeats = p + 2 < size && axis_to_next(p + 1) == axis && step_to_next(p + 1, axis) == step;
                if (repeats || axis != run.axis || step < run.step) run.axis = axis, run.step = step;
                while (p + run.size < size && axis_to_next(p + run.size - 1) == axis &&
                       step_to_next(p + run.size - 1, axis) == run.step)
                    ++run.size;
            }
            for (std::uint32_t k = 0; k < run.size; ++k) run_of_[p + k] = static_cast<std::uint32_t>(runs_.size());
            runs_.push_back(run);
        }
    }

    /// Fills seen_; false when a bond does not fit or one is missing.
    bool look_around(const Run<Real>& run) {
        seen_.clear();
        for (std::uint32_t p = run.first; p < run.first + run.size; ++p)
            for (std::uint32_t slot = bonds_.row[p]; slot < bonds_.row[p + 1]; ++slot)
                if (!see(run, p, slot)) return false;
        return !seen_.empty() && std::all_of(seen_.begin(), seen_.end(), [&](const Seen<Real>& seen) {
            std::int64_t expected = run_of_[run.first] == seen.run ? -std::int64_t{run.size} : 0;
            const auto end = seen.begin + static_cast<std::int32_t>(runs_[seen.run].size);
            for (std::int32_t place = 0; place < static_cast<std::int32_t>(run.size); ++place)
                expected +=
                    std::max(0, std::min(end, place + seen.reach() + 1) - std::max(seen.begin, place - seen.reach()));
            return expected == seen.bonds;
        });
    }

    bool see(const Run<Real>& run, std::uint32_t p, std::uint32_t slot) {
        const std::uint32_t q = bonds_.neighbour[slot];
        const Run<Real>& other = runs_[run_of_[q]];
        if (other.axis != run.axis || other.step != run.step) return false;
        const Real along = at(q)[run.axis] - at(p)[run.axis];
        const auto d = static_cast<std::int32_t>(std::lround(along / run.step));
        if (static_cast<Real>(d) * run.step != along) return false;
        Real across[2];
        for (std::uint32_t c = 0; c < 2; ++c) {
            const std::uint32_t axis = (run.axis + 1 + c) % 3;
            across[c] = at(q)[axis] - at(p)[axis];
        }
        const auto offset = static_cast<std::int32_t>(q - p) - d;

        auto known =
            std::find_if(seen_.begin(), seen_.end(), [&](const Seen<Real>& seen) { return seen.run == run_of_[q]; });
        if (known == seen_.end()) {
            const std::uint32_t begin = p - run.first + static_cast<std::uint32_t>(d) - (q - other.first);
            seen_.push_back({run_of_[q], offset, static_cast<std::int32_t>(begin), {across[0], across[1]}});
            known = seen_.end() - 1;
        }
        if (known->offset != offset || !std::equal(across, across + 2, known->across)) return false;
        const auto distance = static_cast<std::size_t>(std::abs(d));
        if (known->weight.size() <= distance)
            known->weight.resize(distance + 1, std::numeric_limits<Real>::quiet_NaN());
        const Real weight = (shared_ ? shared_[shape_[p] + slot - bonds_.row[p]] : Real(1)) * at(q)[3];
        Real& before = known->weight[distance];
        if (std::isnan(before)) before = weight;
        ++known->bonds;
        return before == weight;
    }

    /// Of seen_. Bonds farther along than a RowNeighbour reaches become neighbours of reach 0.
    std::vector<RowNeighbour<Real>> neighbours_of(const Run<Real>& run) const {
        std::vector<RowNeighbour<Real>> found;
        for (const Seen<Real>& seen : seen_) {
            const auto weight = [&](std::int32_t d) {
                const Real known = seen.weight[static_cast<std::size_t>(std::abs(d))];
                return std::isnan(known) ? Real(0) : known;
            };
            RowNeighbour<Real> whole{.offset = seen.offset, .begin = seen.begin};
            whole.end = seen.begin + static_cast<std::int32_t>(runs_[seen.run].size);
            const auto single = [&](std::int32_t d) {
                RowNeighbour<Real> n = whole;
                n.offset += d, n.begin -= d, n.end -= d;
                for (std::uint32_t c = 0; c < 2; ++c) n.across[c] = weight(d) * seen.across[c];
                n.across[2] = weight(d) * static_cast<Real>(d) * run.step;
                found.push_back(n);
            };
            for (std::int32_t d = kMostReach + 1; d <= seen.reach(); ++d) single(-d), single(d);
            if (seen.reach() == 0) {
                single(0);
                continue;
            }
            whole.reach = static_cast<std::uint32_t>(std::min(seen.reach(), kMostReach));
            std::copy_n(seen.across, 2, whole.across);
            for (std::uint32_t d = 0; d <= whole.reach; ++d) {
                whole.weight[d] = weight(static_cast<std::int32_t>(d));
                whole.along[d] = whole.weight[d] * static_cast<Real>(d) * run.step;
            }
            found.push_back(whole);
        }
        std::stable_sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.reach > b.reach; });
        return found;
    }

    const Bonds& bonds_;
    const Real* reference_;
    const std::uint32_t* shape_;
    const Real* shared_;
    std::vector<Run<Real>> runs_;
    std::vector<std::uint32_t> run_of_;
    std::vector<Seen<Real>> seen_;
    Rows<RowNeighbour<Real>> kept_;
};

}  // namespace

template <class Real>
BondRows<Real> find_lattice_rows(const Bonds& bonds, const Real* reference, const std::uint32_t* shape,
                                 const Real* shared, std::uint32_t shortest, double least_reach) {
    return RowFinder<Real>(bonds, reference, shape, shared)(shortest, least_reach);
}

template BondRows<float> find_lattice_rows(const Bonds&, const float*, const std::uint32_t*, const float*,
                                           std::uint32_t, double);
template BondRows<double> find_lattice_rows(const Bonds&, const double*, const std::uint32_t*, const double*,
                                            std::uint32_t, double);

}  // namespace perimpm
