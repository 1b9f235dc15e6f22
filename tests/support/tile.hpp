#pragma once

#include <functional>
#include <vector>

#include "perimpm/geometry/shape.hpp"
#include "perimpm/model/transfer_kernel.hpp"
#include "state/array.hpp"

/// Particles inside one tile of the grid (nodes 0 to 7 along each axis, dx = `spacing`), for tests of transfer kernels.
template <class Real>
class Tile {
public:
    using Vec3 = perimpm::Vec3;

    Tile(std::size_t size, double spacing) : size_{size}, spacing_{spacing} {}

    void place(std::size_t p, const Vec3& x, const Vec3& v, double m = 1, double volume = 1) {
        for (int c = 0; c < 3; ++c) {
            x_[static_cast<std::size_t>(c)][p] = static_cast<Real>(x[c]);
            v_[static_cast<std::size_t>(c)][p] = static_cast<Real>(v[c]);
        }
        mass_[p] = static_cast<Real>(m), volume_[p] = static_cast<Real>(volume);
        for (std::size_t c = 0; c < 9; c += 4) F_[c][p] = 1;
    }
    void set_C(std::size_t p, const Eigen::Matrix3d& C) {
        for (int c = 0; c < 9; ++c) C_[static_cast<std::size_t>(c)][p] = static_cast<Real>(C(c / 3, c % 3));
    }
    void set_tau(std::size_t p, std::size_t component, double value) { tau_[component][p] = static_cast<Real>(value); }
    Vec3 x(std::size_t p) const { return vector(x_, p); }
    Vec3 v(std::size_t p) const { return vector(v_, p); }
    double mass(std::size_t p) const { return static_cast<double>(mass_[p]); }
    Eigen::Matrix3d C(std::size_t p) const { return matrix(C_, p); }
    Eigen::Matrix3d F(std::size_t p) const { return matrix(F_, p); }

    /// Clears the tile and scatters; `local`: a local law with the stresses that were set, else no forces.
    void scatter(const perimpm::TransferKernel<Real>& kernel, double dt, bool local) {
        tile_ = perimpm::AlignedArray<Real>(kPadded), increment_ = perimpm::AlignedArray<Real>(kPadded);
        perimpm::TransferBlock<Real> b = block(dt, local);
        kernel.scatter(b);
    }
    /// Momentum to velocity, forces included.
    void update() {
        for (std::size_t n = 0; n < kNodes; ++n)
            for (std::size_t c = 0; c < 3 && tile_[4 * n + 3] > 0; ++c) {
                const Real m = tile_[4 * n + 3], before = tile_[4 * n + c] / m, impulse = increment_[4 * n + c] / m;
                tile_[4 * n + c] = before + impulse, increment_[4 * n + c] = before;
            }
    }
    void gather(const perimpm::TransferKernel<Real>& kernel, double dt, bool local) {
        perimpm::TransferBlock<Real> b = block(dt, local);
        kernel.gather(b);
    }

    Vec3 node_position(std::size_t n) const {
        return spacing_ * Vec3(static_cast<double>(n / 64), static_cast<double>(n / 8 % 8), static_cast<double>(n % 8));
    }
    /// Scattered momentum and impulse of node n = (8 i + j) 8 + k.
    Vec3 node_momentum(std::size_t n) const {
        Vec3 sum;
        for (std::size_t c = 0; c < 3; ++c)
            sum[static_cast<int>(c)] = static_cast<double>(tile_[4 * n + c] + increment_[4 * n + c]);
        return sum;
    }
    double node_mass(std::size_t n) const { return static_cast<double>(tile_[4 * n + 3]); }
    /// Sum of `node_momentum` over the plane of nodes with index i along x.
    Vec3 plane_momentum(std::size_t i) const {
        Vec3 sum = Vec3::Zero();
        for (std::size_t n = 64 * i; n < 64 * (i + 1); ++n) sum += node_momentum(n);
        return sum;
    }
    /// Overwrites the nodes' velocities by a field, for tests of `gather`; those before forces by another one.
    void set_velocities(const std::function<Vec3(const Vec3&)>& field) { set(tile_, field); }
    void set_velocities(const std::function<Vec3(const Vec3&)>& field, const std::function<Vec3(const Vec3&)>& before) {
        set(tile_, field), set(increment_, before);
    }
    static constexpr std::size_t kNodes = 512;

private:
    static constexpr std::size_t kPadded =
        perimpm::kTileValues + 16;  ///< as in the core: columns may be read past the end

    perimpm::TransferBlock<Real> block(double dt, bool local) {
        perimpm::TransferBlock<Real> b;
        b.size = static_cast<std::uint32_t>(size_);
        b.dt = static_cast<Real>(dt), b.spacing = static_cast<Real>(spacing_);
        b.x = x_.view(), b.v = v_.view(), b.C = C_.view();
        b.mass = mass_.data(), b.volume = volume_.data();
        if (local)
            b.F = F_.view(), b.tau = tau_.view();
        else
            b.force = force_.view();
        b.tile = tile_.data(), b.increment = increment_.data();
        return b;
    }
    void set(perimpm::AlignedArray<Real>& values, const std::function<Vec3(const Vec3&)>& field) {
        for (std::size_t n = 0; n < kNodes; ++n) {
            const Vec3 v = field(node_position(n));
            for (std::size_t c = 0; c < 3; ++c) values[4 * n + c] = static_cast<Real>(v[static_cast<int>(c)]);
        }
    }
    static Vec3 vector(const perimpm::FieldArray<Real>& f, std::size_t p) {
        return {static_cast<double>(f[0][p]), static_cast<double>(f[1][p]), static_cast<double>(f[2][p])};
    }
    static Eigen::Matrix3d matrix(const perimpm::FieldArray<Real>& f, std::size_t p) {
        Eigen::Matrix3d m;
        for (int c = 0; c < 9; ++c) m(c / 3, c % 3) = static_cast<double>(f[static_cast<std::size_t>(c)][p]);
        return m;
    }

    std::size_t size_;
    double spacing_;
    perimpm::FieldArray<Real> x_{size_, 3}, v_{size_, 3}, C_{size_, 9}, F_{size_, 9}, tau_{size_, 6}, force_{size_, 3};
    perimpm::AlignedArray<Real> mass_{size_}, volume_{size_}, tile_{kPadded}, increment_{kPadded};
};
