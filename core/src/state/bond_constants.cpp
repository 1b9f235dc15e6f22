#include "state/bond_constants.hpp"

#include <algorithm>
#include <array>
#include <string_view>
#include <unordered_map>

#include "perimpm/model/block.hpp"
#include "perimpm/peridynamics/family.hpp"

namespace perimpm {

namespace {

/// The constants of one family, in all arrays.
template <class Real>
struct Constants {
    const std::vector<AlignedArray<Real>*>* arrays;
    std::uint32_t first, size;

    std::string_view bits(std::size_t array) const {
        return {reinterpret_cast<const char*>((*arrays)[array]->data() + first), size * sizeof(Real)};
    }
    friend bool operator==(const Constants& a, const Constants& b) {
        for (std::size_t k = 0; k < a.arrays->size(); ++k)
            if (a.bits(k) != b.bits(k)) return false;
        return true;
    }
};
template <class Real>
struct ConstantsHash {
    std::size_t operator()(const Constants<Real>& constants) const {
        std::size_t hash = 0;
        for (std::size_t k = 0; k < constants.arrays->size(); ++k)
            hash = hash * 0x9e3779b97f4a7c15u + std::hash<std::string_view>()(constants.bits(k));
        return hash;
    }
};

/// The neighbours of a particle as seen from it.
template <class Real>
struct Surroundings {
    const Bonds* bonds;
    const Real* reference;
    std::uint32_t particle;

    std::uint32_t size() const { return bonds->row[particle + 1] - bonds->row[particle]; }
    /// Index, counted from the particle's. Beyond the row's end: what the next rows hold.
    std::uint32_t offset(std::uint32_t k) const { return bonds->neighbour[bonds->row[particle] + k] - particle; }
    /// X and V.
    std::array<Real, 4> neighbour(std::uint32_t k) const {
        const Real* own = reference + 4 * std::size_t{particle};
        const Real* other = reference + 4 * std::size_t{particle + offset(k)};
        return {other[0] - own[0], other[1] - own[1], other[2] - own[2], other[3]};
    }
    friend bool operator==(const Surroundings& a, const Surroundings& b) {
        if (a.size() != b.size()) return false;
        for (std::uint32_t k = 0; k < a.size(); ++k)
            if (a.offset(k) != b.offset(k) || a.neighbour(k) != b.neighbour(k)) return false;
        return true;
    }
};
template <class Real>
struct SurroundingsHash {
    std::size_t operator()(const Surroundings<Real>& around) const {
        std::size_t hash = around.size();
        const auto mix = [&](std::size_t bits) { hash = (hash ^ bits) * 0x9e3779b97f4a7c15u; };
        for (std::uint32_t k = 0; k < around.size(); ++k) {
            mix(around.offset(k));
            for (const Real number : around.neighbour(k)) mix(std::hash<Real>()(number));
        }
        return hash ^ hash >> 32;
    }
};

/// Whether all that a pack of bonds reads past the end of the twin's row, shifted to particle p, are particles.
template <class Real>
bool may_read_past(const Bonds& bonds, const Surroundings<Real>& twin, std::uint32_t p) {
    const std::uint64_t size = bonds.row.size() - 1;
    for (std::uint32_t k = twin.size(); k < twin.size() + kSlotPadding; ++k)
        if (std::uint32_t{p + twin.offset(k)} >= size) return false;
    return true;
}

template <class Real>
AlignedArray<std::uint32_t> twins(const Bonds& bonds, const Real* reference) {
    const auto size = static_cast<std::uint32_t>(bonds.row.size() - 1);
    AlignedArray<std::uint32_t> twin(size);
    std::unordered_map<Surroundings<Real>, std::uint32_t, SurroundingsHash<Real>> known;
    for (std::uint32_t p = 0; p < size; ++p) {
        const auto [found, is_new] = known.try_emplace(Surroundings<Real>{&bonds, reference, p}, p);
        twin[p] = may_read_past(bonds, found->first, p) ? found->second : p;
    }
    return twin;
}

AlignedArray<std::uint8_t> runs(const Bonds& bonds, const AlignedArray<std::uint32_t>& twin) {
    const std::size_t size = twin.size();
    AlignedArray<std::uint8_t> run(size);
    for (std::size_t p = size; p-- > 0;) {
        run[p] = 1;
        if (p + 1 == size || bonds.row[p] == bonds.row[p + 1]) continue;
        const std::size_t last = std::max<std::size_t>(p, bonds.neighbour[bonds.row[p + 1] - 1]);
        if (last + kSlotPadding <= size && twin[p] == twin[p + 1])
            run[p] = static_cast<std::uint8_t>(std::min(255, run[p + 1] + 1));
    }
    return run;
}

}  // namespace

template <class Real>
BondConstants<Real>::BondConstants(const Bonds& bonds, const Real* reference, const FieldSpecs& specs)
    : shape(bonds.row.size() - 1), twin(bonds.row.size() - 1), length(bonds.size(), kSlotPadding) {
    for (std::size_t p = 0; p < shape.size(); ++p) {
        shape[p] = bonds.row[p], twin[p] = static_cast<std::uint32_t>(p);
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
void BondConstants<Real>::share(const Bonds& bonds, const Real* reference) {
    std::vector<AlignedArray<Real>*> arrays{&length};
    for (AlignedArray<Real>& numbers : declared) arrays.push_back(&numbers);
    std::unordered_map<Constants<Real>, std::uint32_t, ConstantsHash<Real>> known;  // where they go
    std::vector<Constants<Real>> kept;
    std::uint32_t end = 0;
    for (std::size_t p = 0; p < shape.size(); ++p) {
        const Constants<Real> own{&arrays, shape[p], bonds.row[p + 1] - bonds.row[p]};
        const auto [found, is_new] = known.try_emplace(own, end);
        shape[p] = found->second;
        if (is_new) kept.push_back(own), end += own.size;
    }
    for (AlignedArray<Real>* numbers : arrays) {
        AlignedArray<Real> shared(end, kSlotPadding);
        Real* to = shared.data();
        for (const Constants<Real>& own : kept) to = std::copy_n(numbers->data() + own.first, own.size, to);
        *numbers = std::move(shared);
    }
    twin = twins(bonds, reference);
    run = runs(bonds, twin);
}

template struct BondConstants<float>;
template struct BondConstants<double>;

}  // namespace perimpm
