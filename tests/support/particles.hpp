#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>
#include <numeric>
#include <random>
#include <vector>

#include "perimpm/model/constitutive_law.hpp"
#include "state/array.hpp"
#include "state/bond_constants.hpp"
#include "state/bonds.hpp"

/// Particles of one material with everything that its law asked for, without a simulation: for tests of laws and
/// criteria.
template <class Real>
class Particles {
public:
    using Vec3 = perimpm::Vec3;
    using Mat3 = Eigen::Matrix3d;
    template <class T>
    using Array = perimpm::AlignedArray<T>;
    template <class T>
    using Fields = perimpm::FieldArray<T>;

    /// At rest at X, each of `volume` [m^3] and of `density` [kg/m^3]. Laws run `initialise`, those of
    /// bonds on their families.
    Particles(const perimpm::ConstitutiveLaw<Real>& law, std::vector<Vec3> X, double volume, double density = 1000.0)
        : law_{law},
          needs_{law.needs()},
          X_{std::move(X)},
          volume_(size()),
          mass_(size()),
          x_(size(), 3),
          v_(size(), 3) {
        for (std::size_t p = 0; p < size(); ++p) {
            volume_[p] = static_cast<Real>(volume);
            mass_[p] = static_cast<Real>(density * volume);
        }
        for (std::uint32_t k = 0; k < needs_.particle_state.size; ++k) {
            const perimpm::FieldSpec& spec = needs_.particle_state.data[k];
            particle_state_.push_back(Fields<Real>::of(spec, size()));
        }
        if (needs_.bonds) build_families();
        if (needs_.deformation_gradient) F_ = Fields<Real>(size(), 9), tau_ = Fields<Real>(size(), 6);
        move([](const Vec3& at) { return at; });
        for (std::size_t p = 0; p < size() && needs_.deformation_gradient; ++p) set_F(p, Mat3::Identity());
        perimpm::Block<Real> all = block();
        for (std::uint32_t round = 0; round < needs_.rounds; ++round) law_.initialise(all, round);
        if (needs_.bonds) constants_.share(bonds_, reference_.data(), needs_);
    }

    std::size_t size() const { return X_.size(); }
    const std::vector<Vec3>& reference() const { return X_; }
    const perimpm::Bonds& bonds() const { return bonds_; }
    perimpm::Bonds& bonds() { return bonds_; }

    /// Moves every particle to map(X).
    void move(const std::function<Vec3(const Vec3&)>& map) {
        for (std::size_t p = 0; p < size(); ++p) place(p, map(X_[p]));
    }
    void deform(const Mat3& F) {
        move([&](const Vec3& at) -> Vec3 { return F * at; });
    }
    void place(std::size_t p, const Vec3& at) {
        for (int c = 0; c < 3; ++c) {
            x_[static_cast<std::size_t>(c)][p] = static_cast<Real>(at[c]);
            if (needs_.bonds) position_[4 * p + static_cast<std::size_t>(c)] = static_cast<Real>(at[c]);
        }
    }
    void set_F(std::size_t p, const Mat3& F) {
        for (std::size_t c = 0; c < 9; ++c)
            F_[c][p] = static_cast<Real>(F(static_cast<int>(c / 3), static_cast<int>(c % 3)));
    }

    perimpm::Block<Real> block(std::size_t first, std::size_t count) {
        perimpm::Block<Real> b;
        b.size = static_cast<std::uint32_t>(count), b.first = static_cast<std::uint32_t>(first);
        b.x = x_.view().from(first), b.v = v_.view().from(first);
        b.mass = mass_.data() + first, b.volume = volume_.data() + first;
        b.F = F_.view().from(first), b.tau = tau_.view().from(first), b.force = force_.view().from(first);
        for (std::size_t k = 0; k < particle_state_.size(); ++k) {
            b.family_state[k] = particle_state_[k].view();
            b.particle_state[k] = particle_state_[k].from(first);
        }
        for (std::size_t k = 0; k < bond_state_.size(); ++k) b.bond_state[k] = bond_state_[k].data();
        if (!needs_.bonds) return b;
        b.family.row = bonds_.row.data() + first;
        b.family.neighbour = bonds_.neighbour.data();
        if (may_break) b.family.broken = bonds_.broken.data(), b.family.damage = bonds_.damage.data() + first;
        b.family.is_cut = bonds_.is_cut;
        b.family.position = position_.data();
        b.family.reference = reference_.data();
        b.family.volume = volume_.data();
        b.family.shape = constants_.shape.data() + first;
        b.family.length = constants_.length.data();
        if (in_slices) b.family.slices = constants_.slices.view();
        if (in_slices && in_rows) b.family.rows = constants_.rows.view();
        b.family.y = x_.view();
        for (std::size_t k = 0; k < constants_.declared.size(); ++k)
            b.bond_constants[k] = constants_.declared[k].data();
        return b;
    }
    perimpm::Block<Real> block() { return block(0, size()); }

    /// Reference quantities after bonds broke.
    void renew() {
        perimpm::Block<Real> all = block();
        law_.renew(all);
    }
    Real largest_stretch = 0;  ///< of the last `evaluate`
    bool in_slices = true;     ///< whether laws see slices of families
    bool in_rows = true;       ///< whether laws see rows of a lattice
    bool may_break = true;     ///< whether laws see that bonds may break
    /// Slices that laws may take together, and all of them.
    std::array<std::ptrdiff_t, 2> slices() const {
        const auto& all = constants_.slices.slice;
        const auto may = [](const perimpm::Slice& slice) { return slice.size > 0; };
        return {std::count_if(all.data(), all.data() + all.size(), may), static_cast<std::ptrdiff_t>(all.size())};
    }
    /// Particles in rows of a lattice that laws may take together.
    std::size_t in_lattice_rows() const {
        const auto& all = constants_.rows.row;
        return std::accumulate(all.data(), all.data() + all.size(), std::size_t{0},
                               [](std::size_t sum, const perimpm::LatticeRow& row) { return sum + row.size; });
    }
    /// Stress or force of all particles, in blocks of at most `chunk` particles.
    void evaluate(std::size_t chunk = ~std::size_t{0}) {
        const auto each = [&](auto call) {
            for (std::size_t first = 0; first < size(); first += std::min(chunk, size())) {
                perimpm::Block<Real> b = block(first, std::min(chunk, size() - first));
                call(b);
            }
        };
        if (needs_.prepare) each([&](perimpm::Block<Real>& b) { law_.prepare(b); });
        largest_stretch = 0;
        each([&](perimpm::Block<Real>& b) {
            law_.evaluate(b, Real(1e-4));
            largest_stretch = std::max(largest_stretch, b.largest_stretch);
        });
    }
    /// Stored energy [J] of the present state, family quantities included; of all particles or of one.
    double energy() { return energy(0, size()); }
    double energy(std::size_t first, std::size_t count) {
        perimpm::Block<Real> all = block();
        if (needs_.prepare) law_.prepare(all);
        return law_.energy(block(first, count));
    }

    /// Energy of each bond at its two ends [J], by slot, of the state evaluated last.
    std::array<std::vector<Real>, 2> bond_energies(std::size_t chunk = ~std::size_t{0}) {
        std::array<std::vector<Real>, 2> ends;
        for (std::vector<Real>& end : ends) end.assign(bonds_.size() + perimpm::kSlotPadding, Real(-1));
        for (std::size_t first = 0; first < size(); first += std::min(chunk, size())) {
            perimpm::Block<Real> b = block(first, std::min(chunk, size() - first));
            b.stored = {ends[0].data() + b.family.row[0], ends[1].data() + b.family.row[0]};
            law_.bond_energy(b);
        }
        for (std::vector<Real>& end : ends) end.resize(bonds_.size());
        return ends;
    }

    Mat3 tau(std::size_t p) const {
        Mat3 t;
        constexpr std::size_t at[9] = {0, 1, 2, 1, 3, 4, 2, 4, 5};
        for (int c = 0; c < 9; ++c) t(c / 3, c % 3) = static_cast<double>(tau_[at[c]][p]);
        return t;
    }
    Vec3 force(std::size_t p) const {
        return {static_cast<double>(force_[0][p]), static_cast<double>(force_[1][p]),
                static_cast<double>(force_[2][p])};
    }
    double largest_force() const {
        double largest = 0;
        for (std::size_t p = 0; p < size(); ++p) largest = std::max(largest, force(p).norm());
        return largest;
    }

private:
    void build_families() {
        const std::size_t whole[] = {0, size()};
        bonds_ = perimpm::build_bonds(X_, whole, needs_.horizon, true);
        position_ = Array<Real>(4 * size()), reference_ = Array<Real>(4 * size());
        force_ = Fields<Real>(size(), 3);
        for (std::size_t p = 0; p < size(); ++p) {
            for (int c = 0; c < 3; ++c) reference_[4 * p + static_cast<std::size_t>(c)] = static_cast<Real>(X_[p][c]);
            reference_[4 * p + 3] = volume_[p];
        }
        constants_ = perimpm::BondConstants<Real>(bonds_, reference_.data(), needs_.bond_constants);
        for (std::uint32_t k = 0; k < needs_.bond_state.size; ++k) {
            bond_state_.emplace_back(bonds_.size(), perimpm::kSlotPadding);
            std::fill_n(bond_state_.back().data(), bonds_.size(), static_cast<Real>(needs_.bond_state.data[k].initial));
        }
    }

    const perimpm::ConstitutiveLaw<Real>& law_;
    perimpm::LawNeeds needs_;
    std::vector<Vec3> X_;
    Array<Real> volume_, mass_, position_, reference_;
    Fields<Real> x_, v_, F_, tau_, force_;
    std::vector<Fields<Real>> particle_state_;
    std::vector<Array<Real>> bond_state_;
    perimpm::Bonds bonds_;
    perimpm::BondConstants<Real> constants_;
};

/// Points of the cubic lattice with spacing h: `count` along each axis, the middle one (for odd counts) at the origin.
inline std::vector<perimpm::Vec3> lattice(int count, double h) {
    std::vector<perimpm::Vec3> points;
    for (int i = 0; i < count; ++i)
        for (int j = 0; j < count; ++j)
            for (int k = 0; k < count; ++k)
                points.push_back(h * (perimpm::Vec3(i, j, k) - perimpm::Vec3::Constant(count / 2)));
    return points;
}

/// Points of n x n rows of `length` points along z.
inline std::vector<perimpm::Vec3> rows_of_particles(int n, int length, double h) {
    std::vector<perimpm::Vec3> points;
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j)
            for (int k = 0; k < length; ++k) points.push_back(h * perimpm::Vec3(i, j, k));
    return points;
}

/// Index of the lattice's middle point.
inline std::size_t middle(int count) {
    const auto n = static_cast<std::size_t>(count), m = n / 2;
    return (m * n + m) * n + m;
}

inline Eigen::Matrix3d rotation(double angle, const perimpm::Vec3& axis) {
    return Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
}

inline Eigen::Matrix3d diagonal(double a, double b, double c) { return perimpm::Vec3(a, b, c).asDiagonal(); }

/// The lateral stretch at which a bar of this axial stretch has no lateral stress, which grows with it; tau(F) in any unit.
template <class Tau>
double lateral_stretch(double axial, Tau tau) {
    double low = 0.5, high = 1.5;
    for (int i = 0; i < 60; ++i) {
        const double s = 0.5 * (low + high);
        (tau(diagonal(axial, s, s))(1, 1) < 0 ? low : high) = s;
    }
    return low;
}

/// Entries uniform in [-1, 1].
inline Eigen::Matrix3d random_matrix(std::mt19937& random) {
    std::uniform_real_distribution<double> entry(-1.0, 1.0);
    Eigen::Matrix3d m;
    for (int c = 0; c < 9; ++c) m(c / 3, c % 3) = entry(random);
    return m;
}
