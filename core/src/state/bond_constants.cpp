#include "state/bond_constants.hpp"

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>
#include <type_traits>

#include "perimpm/peridynamics/family.hpp"
#include "state/kept_rows.hpp"

namespace perimpm {

namespace {

/// Rows of which each has as many numbers of every array, one array after the other: to the ends of these, from `first`
/// on.
template <class Real>
void append(const Rows<Real>& all, std::size_t first, const std::vector<AlignedArray<Real>*>& arrays) {
    for (std::size_t k = 0; k < arrays.size(); ++k) {
        AlignedArray<Real>& before = *arrays[k];
        AlignedArray<Real> whole(first + all.items.size() / arrays.size(), kSlotPadding);
        std::copy_n(before.data(), before.size(), whole.data());
        Real* to = whole.data() + first;
        for (const auto& row : all.kept.rows) {
            const std::size_t size = row.size / arrays.size();
            to = std::copy_n(all.items.data() + row.first + k * size, size, to);
        }
        before = std::move(whole);
    }
}

/// A neighbour as seen from a particle.
template <class Real>
struct Entry {
    std::int64_t offset;  ///< in memory
    Real X[3], V, shared, unused = 0;
};
static_assert(std::has_unique_object_representations_v<Entry<std::int32_t>> &&
              std::has_unique_object_representations_v<Entry<std::int64_t>>);  // bits are compared: no holes

/// Families of particles in a row, merged.
template <class Real>
struct MergedFamilies {
    static constexpr std::uint32_t kNone = ~0u;
    std::vector<Entry<Real>> entries;
    std::vector<std::uint32_t> masks, bond;  ///< bond: place in its family, by entry and lane; kNone
    bool is_whole = true;

    /// Of `lanes` families from that of `first` on; false, and then worthless, when more than `most` entries are found or
    /// one whose neighbours are no particles for all lanes.
    /// `shared`: the bonds' shared constant, indexed like the others; null: none.
    bool merge(const Bonds& bonds, const Real* reference, const std::uint32_t* shape, const Real* shared,
               std::uint32_t first, std::uint32_t lanes, std::size_t most) {
        entries.clear(), masks.clear(), bond.clear();
        is_whole = true;
        next_.assign(bonds.row.data() + first, bonds.row.data() + first + lanes);
        const std::int64_t last = static_cast<std::int64_t>(bonds.row.size()) - 1 - lanes - first;
        for (;;) {
            std::int64_t nearest = std::numeric_limits<std::int64_t>::max();
            for (std::uint32_t lane = 0; lane < lanes; ++lane)
                if (next_[lane] < bonds.row[first + lane + 1]) nearest = std::min(nearest, offset(bonds, first, lane));
            if (nearest == std::numeric_limits<std::int64_t>::max()) return !entries.empty();
            if (entries.size() == most || nearest < -std::int64_t{first} || nearest > last) return false;
            Entry<Real> entry{};
            std::uint32_t mask = 0;
            for (std::uint32_t lane = 0; lane < lanes; ++lane) {
                bond.push_back(kNone);
                if (next_[lane] == bonds.row[first + lane + 1] || offset(bonds, first, lane) != nearest) continue;
                Entry<Real> own = seen(reference, first + lane, nearest);
                own.shared = !shared ? Real(1) : shared[shape[first + lane] + next_[lane] - bonds.row[first + lane]];
                if (mask == 0) entry = own;
                if (std::memcmp(&own, &entry, sizeof own) != 0) continue;
                mask |= 1u << lane;
                bond.back() = next_[lane]++ - bonds.row[first + lane];
            }
            entries.push_back(entry), masks.push_back(mask);
            is_whole = is_whole && std::popcount(mask) == static_cast<int>(lanes);
        }
    }

private:
    std::int64_t offset(const Bonds& bonds, std::uint32_t first, std::uint32_t lane) const {
        return std::int64_t{bonds.neighbour[next_[lane]]} - (first + lane);
    }
    static Entry<Real> seen(const Real* reference, std::uint32_t particle, std::int64_t offset) {
        const Real* own = reference + 4 * std::size_t{particle};
        const Real* other = own + 4 * offset;
        return {offset, {other[0] - own[0], other[1] - own[1], other[2] - own[2]}, other[3], Real(0)};
    }

    std::vector<std::uint32_t> next_;  ///< by lane: slot of the bond that comes next
};

/// The axes of a slice and the sums over the bonds on each.
template <class Real>
struct Axes {
    static constexpr std::size_t kProducts = 6;
    std::vector<Real> products;  ///< n n by axis
    std::vector<Real> sums;      ///< by axis and lane

    /// `constants`: by entry and lane.
    void gather(const std::vector<Entry<Real>>& entries, const Real* constants, std::uint32_t lanes) {
        directions_.clear(), products.clear(), totals_.clear();
        for (std::size_t k = 0; k < entries.size(); ++k) {
            const Vec3 X(entries[k].X[0], entries[k].X[1], entries[k].X[2]);
            const std::size_t axis = axis_of(X.normalized(), lanes);
            for (std::uint32_t lane = 0; lane < lanes; ++lane)
                totals_[axis * lanes + lane] += static_cast<double>(constants[k * lanes + lane]) * X.squaredNorm();
        }
        sums.assign(totals_.begin(), totals_.end());
    }

private:
    /// Directions that differ by rounding are one.
    std::size_t axis_of(const Vec3& n, std::uint32_t lanes) {
        constexpr double kRounding = 4 * std::numeric_limits<Real>::epsilon();
        const auto same = [&](const Vec3& other) { return n.cross(other).norm() <= kRounding; };
        const auto found = std::find_if(directions_.begin(), directions_.end(), same);
        const auto axis = static_cast<std::size_t>(found - directions_.begin());
        if (found != directions_.end()) return axis;
        directions_.push_back(n);
        totals_.resize(directions_.size() * lanes);
        constexpr int row[6] = {0, 0, 0, 1, 1, 2}, column[6] = {0, 1, 2, 1, 2, 2};
        for (int c = 0; c < 6; ++c) products.push_back(static_cast<Real>(n[row[c]] * n[column[c]]));
        return axis;
    }

    std::vector<Vec3> directions_;
    std::vector<double> totals_;
};

/// Slices in which families that are in none have neighbours.
void mark_read_alone(const Bonds& bonds, AlignedArray<Slice>& slices, std::uint32_t lanes) {
    const std::size_t whole = (bonds.row.size() - 1) / lanes * lanes;
    for (std::size_t p = 0; p + 1 < bonds.row.size(); ++p) {
        if (p < whole && slices[p / lanes].size > 0) continue;
        for (std::uint32_t slot = bonds.row[p]; slot < bonds.row[p + 1]; ++slot)
            slices[bonds.neighbour[slot] / lanes].read_alone = true;
    }
}

}  // namespace

template <class Real>
Slices<Real> BondSlices<Real>::view() const {
    return {lanes,         slice.data(), offset.data(), bond.data(), length.data(),
            moment.data(), mask.data(),  axis.data(),   sum.data()};
}

template <class Real>
BondConstants<Real>::BondConstants(const Bonds& bonds, const Real* reference, const FieldSpecs& specs)
    : shape(bonds.row.size() - 1), length(bonds.size(), kSlotPadding) {
    for (std::size_t p = 0; p < shape.size(); ++p) {
        shape[p] = bonds.row[p];
        for (std::uint32_t slot = bonds.row[p]; slot < bonds.row[p + 1]; ++slot) {
            const Real* own = reference + 4 * p;
            const Real* other = reference + 4 * std::size_t{bonds.neighbour[slot]};
            const Real X[3] = {other[0] - own[0], other[1] - own[1], other[2] - own[2]};
            length[slot] = peridynamics::norm(X);
        }
    }
    for (std::uint32_t k = 0; k < specs.size; ++k) {
        declared.emplace_back(bonds.size(), kSlotPadding);
        std::fill_n(declared.back().data(), bonds.size(), static_cast<Real>(specs.data[k].initial));
    }
}

template <class Real>
void BondConstants<Real>::share(const Bonds& bonds, const Real* reference, const LawNeeds& needs) {
    std::vector<AlignedArray<Real>*> arrays{&length};
    for (AlignedArray<Real>& numbers : declared) arrays.push_back(&numbers);
    KeptRows kept;
    std::size_t end = 0;
    for (std::size_t p = 0; p < shape.size(); ++p) {  // rows only move towards the front
        const std::size_t first = bonds.row[p], size = bonds.row[p + 1] - first;
        std::size_t hash = 0;
        for (const AlignedArray<Real>* numbers : arrays)
            hash = hash * 0x9e3779b97f4a7c15u + std::hash<std::string_view>()(bits(numbers->data() + first, size));
        const std::size_t at = kept.find(hash, size, end, [&](std::size_t other) {
            return std::all_of(arrays.begin(), arrays.end(), [&](const AlignedArray<Real>* numbers) {
                return bits(numbers->data() + other, size) == bits(numbers->data() + first, size);
            });
        });
        shape[p] = static_cast<std::uint32_t>(at);
        if (at != end) continue;
        for (AlignedArray<Real>* numbers : arrays) std::copy_n(numbers->data() + first, size, numbers->data() + end);
        end += size;
    }
    for (AlignedArray<Real>* numbers : arrays) {
        const AlignedArray<Real> before = std::move(*numbers);
        *numbers = AlignedArray<Real>(end, kSlotPadding);
        for (std::size_t k = 0; k < end; ++k) (*numbers)[k] = before[k];
    }
    if (needs.lanes > 0) make_slices(bonds, reference, needs);
}

template <class Real>
void BondConstants<Real>::make_slices(const Bonds& bonds, const Real* reference, const LawNeeds& needs) {
    const std::uint32_t lanes = needs.lanes;
    // a slice takes as long as it has entries; with more of them, over bonds of a family on average, families are faster
    // one by one (tests/bench/README.md)
    const std::size_t worthwhile = std::min(4u, lanes / 2);
    const auto size = static_cast<std::uint32_t>(shape.size());
    slices.slice = AlignedArray<Slice>((size + lanes - 1) / lanes);
    std::vector<AlignedArray<Real>*> arrays;
    for (std::size_t k = 0; k < declared.size(); ++k)
        if (static_cast<int>(k) != needs.shared) arrays.push_back(&declared[k]);
    const auto* const axial = needs.axial < 0 ? nullptr : &declared[static_cast<std::size_t>(needs.axial)];
    const auto axial_at = static_cast<std::size_t>(std::find(arrays.begin(), arrays.end(), axial) - arrays.begin());
    const std::size_t used = declared.empty() ? 0 : declared.front().size();
    const std::size_t before = (used + lanes - 1) / lanes * lanes;  // on a border of a register
    Rows<Entry<Real>> entries;
    Rows<std::uint32_t> masks;
    Rows<Real> constants, products, sums;
    std::vector<Real> numbers;
    const Real* shared = needs.shared < 0 ? nullptr : declared[static_cast<std::size_t>(needs.shared)].data();
    MergedFamilies<Real> merged;
    Axes<Real> axes;
    for (std::uint32_t first = 0; first + lanes <= size; first += lanes) {
        const std::size_t count = bonds.row[first + lanes] - bonds.row[first];
        if (!merged.merge(bonds, reference, shape.data(), shared, first, lanes, worthwhile * count / lanes)) continue;
        numbers.clear();
        for (const AlignedArray<Real>* array : arrays)
            for (std::size_t k = 0; k < merged.bond.size(); ++k) {
                const std::uint32_t bond = merged.bond[k];
                numbers.push_back(bond == merged.kNone ? Real(0) : (*array)[shape[first + k % lanes] + bond]);
            }
        Slice& slice = slices.slice[first / lanes];
        slice.first = static_cast<std::uint32_t>(entries.keep(merged.entries));
        slice.size = static_cast<std::uint32_t>(merged.entries.size());
        slice.masks = merged.is_whole ? Slice::kWhole : static_cast<std::uint32_t>(masks.keep(merged.masks));
        if (!arrays.empty()) slice.constants = before + constants.keep(numbers) / arrays.size();
        if (!axial) continue;
        axes.gather(merged.entries, numbers.data() + axial_at * merged.bond.size(), lanes);
        slice.axes = static_cast<std::uint32_t>(axes.products.size() / Axes<Real>::kProducts);
        slice.axis = static_cast<std::uint32_t>(products.keep(axes.products) / Axes<Real>::kProducts);
        slice.sums = sums.keep(axes.sums);
    }
    if (entries.items.empty()) {
        slices = {};
        return;
    }
    mark_read_alone(bonds, slices.slice, lanes);
    // with less reach slices are faster (tests/bench/README.md), with fewer particles most of a pack would be idle
    constexpr double kLeastReach = 1.5;
    const std::uint32_t shortest = std::max(2u, lanes / 4);
    if (needs.rows) rows = find_lattice_rows(bonds, reference, shape.data(), shared, shortest, kLeastReach);
    append(constants, before, arrays);
    slices.lanes = lanes;
    slices.mask = aligned(masks.items);
    slices.axis = aligned(products.items), slices.sum = aligned(sums.items);
    const std::size_t kept = entries.items.size();
    slices.offset = AlignedArray<std::int32_t>(kept);
    slices.length = AlignedArray<Real>(kept), slices.bond = AlignedArray<Real>(4 * kept);
    slices.moment = AlignedArray<Real>(4 * kept);
    for (std::size_t k = 0; k < kept; ++k) {
        const Entry<Real>& entry = entries.items[k];
        slices.offset[k] = static_cast<std::int32_t>(entry.offset);
        slices.length[k] = peridynamics::norm(entry.X);
        std::copy_n(entry.X, 3, slices.bond.data() + 4 * k);
        slices.bond[4 * k + 3] = entry.V;
        for (std::size_t c = 0; c < 3; ++c) slices.moment[4 * k + c] = entry.shared * entry.V * entry.X[c];
    }
}

template struct BondConstants<float>;
template struct BondConstants<double>;
template struct BondSlices<float>;
template struct BondSlices<double>;

}  // namespace perimpm
