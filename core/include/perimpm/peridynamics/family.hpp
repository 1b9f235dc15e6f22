#pragma once

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "perimpm/math/quads.hpp"
#include "perimpm/math/root.hpp"
#include "perimpm/model/constitutive_law.hpp"

/*! What bond laws share: walking through families in packs of bonds, lengths, sums over the full lattice. */
namespace perimpm::peridynamics {

template <class T>
PERIMPM_INLINE T square_of(const T v[3]) {
    return v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
}
template <class T>
PERIMPM_INLINE Root<T> length_of(const T v[3]) {
    return root_of(square_of(v));
}
template <class T>
PERIMPM_INLINE T norm(const T v[3]) {
    return length_of(v).root;
}

/// Bonds ahead of which their numbers are asked for: they come from memory, in more and longer runs than the processor
/// foresees by itself.
inline constexpr std::uint32_t kPrefetchBonds = 512;
template <class T>
PERIMPM_INLINE void prefetch(const T* by_slot) {
    __builtin_prefetch(by_slot + kPrefetchBonds);
}

/// Index of the constants of the bond in `slot` of the block's particle i.
template <class Real>
std::uint32_t constant_of(const Families<Real>& f, std::uint32_t i, std::uint32_t slot) {
    return f.shape[i] + (slot - f.row[i]);
}

/// A pack of bonds of one particle. Lanes beyond `size` show bonds of other particles.
template <class Real>
struct BondPack {
    std::uint32_t slot, size, first_constant;
    const std::uint32_t* neighbours;
    const Real* lengths;  ///< Families::length

    PERIMPM_INLINE std::size_t neighbour(std::size_t lane) const { return neighbours[lane]; }
    /// |X|.
    PERIMPM_INLINE Pack<Real> length() const { return constant(lengths); }

    /// Value of a per-bond field.
    PERIMPM_INLINE Pack<Real> load(const Real* field) const {
        prefetch(field + slot);
        return Pack<Real>(field + slot, std::experimental::element_aligned);
    }
    /// Value of a constant.
    PERIMPM_INLINE Pack<Real> constant(const Real* numbers) const {
        prefetch(numbers + first_constant);
        return Pack<Real>(numbers + first_constant, std::experimental::element_aligned);
    }
    /// Value of a field of the neighbours, indexed over the whole material.
    PERIMPM_INLINE Pack<Real> gather(const Real* field) const {
        return Pack<Real>([&](std::size_t lane) { return field[neighbour(lane)]; });
    }
    /// The neighbours' entries of a field whose entries are Width numbers side by side.
    template <std::size_t Width>
    PERIMPM_INLINE void gather_packed(const Real* field, Pack<Real> out[Width]) const {
        for (std::size_t q = 0; q < Width; q += 4) gather_quads<Width>(field + q, neighbours, out + q);
    }
    /// Vectors from the particle at `own` to its neighbours; both in arrays packed by four.
    PERIMPM_INLINE void difference(const Real* packed, const Real* own, Pack<Real> out[3]) const {
        Pack<Real> quad[4];
        gather_quads(packed, neighbours, quad);
        for (int c = 0; c < 3; ++c) out[c] = quad[c] - own[c];
    }
};

/// 1 for the live bonds among `size` from `slot` on, 0 for broken ones and for the remaining lanes. A call of its own:
/// most families have no broken bonds.
template <class Real>
[[gnu::noinline]] Pack<Real> unbroken_bonds(const Families<Real>& f, std::uint32_t slot, std::uint32_t size) {
    return ones_at<Real>(~f.broken_from(slot) & ((1u << size) - 1));
}
template <class Real>
PERIMPM_INLINE Pack<Real> live_bonds(const Families<Real>& f, std::uint32_t slot, std::uint32_t size, bool damaged) {
    if (damaged) return unbroken_bonds(f, slot, size);
    return select(first_lanes<Real>(size), Pack<Real>(1), Pack<Real>(0));
}

/// Calls body(pack, live) for the bonds in the slots from `slot` to `end` of the block's particle i; `live` is 1 for whole
/// bonds, 0 for broken ones and for lanes beyond the pack's size. Undamaged families read no flags.
template <class Real, class Body>
PERIMPM_INLINE void for_each_bond(const Block<Real>& b, std::uint32_t i, std::uint32_t slot, std::uint32_t end,
                                  Body body) {
    constexpr std::uint32_t lanes = kLanes<Real>;
    static_assert(lanes <= kSlotPadding);
    const Families<Real>& f = b.family;
    const bool damaged = f.damage && f.damage[i] > 0;
    const std::uint32_t* neighbours = f.neighbour + slot;
    std::uint32_t constant = constant_of(f, i, slot);
    for (; !damaged && slot + lanes <= end; slot += lanes, constant += lanes, neighbours += lanes) {
        prefetch(neighbours);
        body(BondPack<Real>{slot, lanes, constant, neighbours, f.length}, Pack<Real>(1));
    }
    for (; slot < end; slot += lanes, constant += lanes, neighbours += lanes) {
        const std::uint32_t size = std::min(lanes, end - slot);
        prefetch(neighbours);
        body(BondPack<Real>{slot, size, constant, neighbours, f.length}, live_bonds(f, slot, size, damaged));
    }
}
/// The same for all bonds of the block's particle i.
template <class Real, class Body>
PERIMPM_INLINE void for_each_bond(const Block<Real>& b, std::uint32_t i, Body body) {
    for_each_bond(b, i, b.family.row[i], b.family.row[i + 1], body);
}

/// ConstitutiveLaw::bond_energy of a pack of bonds. Packs come in order of slot: one that reaches into the next row is
/// overwritten by that row's first.
template <class Real>
PERIMPM_INLINE void store_energy(const Block<Real>& b, const BondPack<Real>& bonds, const Pack<Real>& own,
                                 const Pack<Real>& other) {
    const std::uint32_t at = bonds.slot - b.family.row[0];
    own.copy_to(b.stored.own + at, std::experimental::element_aligned);
    other.copy_to(b.stored.other + at, std::experimental::element_aligned);
}

/// (|Z| - |X|)/|Z|, of which Z times the stiffness is a spring's force.
template <class T>
PERIMPM_INLINE T relative_extension(const Root<T>& z, const T& length) {
    return (z.root - length) * z.inverse;
}
/// The stretch (|Y| - |X|)/|X| that belongs to a relative extension; infinite where that is 1 by rounding.
template <class Real>
Real stretch_of(Real relative_extension) {
    return relative_extension < 1 ? relative_extension / (1 - relative_extension)
                                  : std::numeric_limits<Real>::infinity();
}

/// sum of value(|X|) V over the full family on the lattice that the material's bodies have: cubic, square, or along a line;
/// of its neighbours in the layers from `first` on along the lattice's first axis.
template <class Value>
double lattice_sum(double horizon, const ModelContext& c, Value value, int first = std::numeric_limits<int>::min()) {
    const double h = c.particle_spacing;
    const int reach = static_cast<int>(horizon / h) + 1, wide = c.dimension > 1 ? reach : 0,
              deep = c.dimension > 2 ? reach : 0;
    double sum = 0;
    for (int i = std::max(-reach, first); i <= reach; ++i)
        for (int j = -wide; j <= wide; ++j)
            for (int k = -deep; k <= deep; ++k) {
                const double length = h * std::sqrt(double(i * i + j * j + k * k));
                if (length <= 0 || length > horizon * (1 + 1e-9)) continue;  // as build_bonds
                double share = value(length) * c.across;
                for (std::uint32_t d = 0; d < c.dimension; ++d) share *= h;
                sum += share;
            }
    return sum;
}

/*! Energy per area of a plane midway between two layers of the lattice, all bonds across it stretched by s and no others, over
    s^2 [J/m^2]: LawNeeds::opening_energy. In the family of a particle k layers away the share r_k of the weights is stretched;
    its energy density is s^2 (linear r_k + quadratic r_k^2), hence
      (1) G/s^2 = 2 h sum_k (linear r_k + quadratic r_k^2)
    For springs this is (Silling & Askari 2005, eq. 26) summed over the lattice. For the linear peridynamic solid in the
    limit of many neighbours, weights w x^2 = x, it is (3 mu + (26/45) (K - 5 mu/3)) delta; the (3/4)^4 that is often
    printed in place of 26/45 is not its integral. */
template <class Weight>
double opening_energy(double horizon, const ModelContext& c, Weight weight, double linear, double quadratic = 0) {
    const double whole = lattice_sum(horizon, c, weight);
    double energy = 0;
    for (int k = 0; k * c.particle_spacing < horizon; ++k) {
        const double share = lattice_sum(horizon, c, weight, k + 1) / whole;
        energy += 2 * c.particle_spacing * (linear * share + quadratic * share * share);
    }
    return energy;
}

/*! Springs of weight w along bonds, on average over all directions of a family that fills d dimensions: solids 3, sheets 2,
    strands 1. With S = sum w V, times their stiffness,
      sum w V n n n n = S (1 1 + 1 1 + 1 1)/(d (d + 2)),  hence  M = 3 S/(d (d + 2))    modulus of uniaxial strain
      nu = 1/(d + 1),  E = 2 S/(d (d + 1)) = M 2 (d + 2)/(3 (d + 1))
    Sheets are in plane stress: nothing acts across them, E/(1 - nu^2) = M with nu = 1/3. Strands: E = M. */
struct SpringLattice {
    double d;  ///< dimensions
    explicit SpringLattice(const ModelContext& c) : d{static_cast<double>(c.dimension)} {}
    double poisson_ratio() const { return 1 / (d + 1); }
    double sum_of_modulus() const { return d * (d + 2) / 3; }                ///< S/M
    double modulus_of_young() const { return 3 * (d + 1) / (2 * (d + 2)); }  ///< M/E
};

/// Largest |Y|/|X| over the live bonds of the block, at least 1: waves travel faster through stretched families.
template <class Real>
double largest_stretch(const Block<Real>& b) {
    Pack<Real> largest(1);
    for (std::uint32_t i = 0; i < b.size; ++i) {
        const Real* own = b.family.position + 4 * std::size_t{b.first + i};
        for_each_bond(b, i, [&](const BondPack<Real>& bonds, const Pack<Real>& live) {
            Pack<Real> Y[3];
            bonds.difference(b.family.position, own, Y);
            const Pack<Real> stretch = live * norm(Y) * inverse_length(bonds.length());
            largest = select(stretch > largest, stretch, largest);
        });
    }
    return static_cast<double>(hmax(largest));
}

/// Stable steps of bonds that are at most as stiff as springs of k = `stiffness` * scale [N/m]. Forces of springs along n = dir Y
/// with stretch s change by [k n n + k s/(1 + s) (1 - n n)] (du_q - du_p); with (a - b)^2 <= 2 a^2 + 2 b^2, for s = 0
///   omega^2 <= 2 max_p (largest eigenvalue of sum_q k_pq n n)/m_p
/// and for any s Silling & Askari 2005, eq. 50: dt < sqrt(2 m_p / sum_q k_pq), which is up to sqrt(3) times smaller. Here n is
/// dir X: families squeezed flat or thin turn their bonds one way, which the share that automatic steps keep is for.
template <class Real>
StableStep spring_bound(const Block<Real>& b, const Real* stiffness, double scale) {
    double softest = std::numeric_limits<double>::infinity(), any = softest;
    for (std::uint32_t i = 0; i < b.size; ++i) {
        Eigen::Matrix3d along = Eigen::Matrix3d::Zero();
        const Real* own = b.family.reference + 4 * std::size_t{b.first + i};
        for (std::uint32_t slot = b.family.row[i]; slot < b.family.row[i + 1]; ++slot) {
            const Real* other = b.family.reference + 4 * std::size_t{b.family.neighbour[slot]};
            const Eigen::Vector3d X(other[0] - own[0], other[1] - own[1], other[2] - own[2]);
            const double k = scale * static_cast<double>(stiffness[constant_of(b.family, i, slot)]);
            along += k / X.squaredNorm() * X * X.transpose();
        }
        const double trace = along.trace();
        if (trace <= 0) continue;
        const double largest = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>()
                                   .computeDirect(along, Eigen::EigenvaluesOnly)
                                   .eigenvalues()[2];
        const double twice = 2 * static_cast<double>(b.mass[i]);
        softest = std::min(softest, std::sqrt(twice / largest)), any = std::min(any, std::sqrt(twice / trace));
    }
    return {softest, any};
}

}  // namespace perimpm::peridynamics
