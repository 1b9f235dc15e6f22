#pragma once

#include <map>
#include <vector>

#include "state/bond_constants.hpp"
#include "support/particles.hpp"

constexpr double kSpacing = 1 / 64.0;

/// Families of particles of volume 2 with an influence that falls with the distance.
template <class Real>
struct LatticeFamilies {
    std::vector<Real> reference;
    perimpm::Bonds bonds;
    perimpm::BondConstants<Real> constants;

    LatticeFamilies(const std::vector<perimpm::Vec3>& X, double horizon) {
        const std::size_t whole[] = {0, X.size()};
        bonds = perimpm::build_bonds(X, whole, horizon, false);
        for (const perimpm::Vec3& x : X) {
            for (int c = 0; c < 3; ++c) reference.push_back(static_cast<Real>(x[c]));
            reference.push_back(2);
        }
        rebuild_constants();
    }
    void rebuild_constants() {
        static constexpr perimpm::FieldSpec kDeclared[] = {{.name = "influence"}};
        constants = perimpm::BondConstants<Real>(bonds, reference.data(), kDeclared);
        for (std::size_t k = 0; k < bonds.size(); ++k) influence()[k] = 1 / constants.length[k];
    }
    Real* influence() { return constants.declared[0].data(); }
    perimpm::BondRows<Real> rows(std::uint32_t shortest = 2, double least_reach = 0) {
        return perimpm::find_lattice_rows(bonds, reference.data(), constants.shape.data(), influence(), shortest,
                                          least_reach);
    }
    /// w V X of the bonds of a particle, by neighbour.
    std::map<std::size_t, perimpm::Vec3> moments(std::size_t p) {
        std::map<std::size_t, perimpm::Vec3> all;
        for (std::uint32_t slot = bonds.row[p]; slot < bonds.row[p + 1]; ++slot) {
            const std::size_t q = bonds.neighbour[slot];
            for (std::size_t c = 0; c < 3; ++c)
                all[q][static_cast<int>(c)] = static_cast<double>(influence()[slot] * reference[4 * q + 3] *
                                                                  (reference[4 * q + c] - reference[4 * p + c]));
        }
        return all;
    }
};

/// n x n rows of `length` particles along an axis, of a box or of the hollow ellipsoid in it, in the order of the rows.
inline std::vector<perimpm::Vec3> rows_along(int axis, bool is_box, int n = 8, int length = 23) {
    using perimpm::Vec3;
    std::vector<Vec3> X = rows_of_particles(n, length, kSpacing);
    const Vec3 half = Vec3(n, n, length) / 2;
    if (!is_box)
        std::erase_if(X, [&](const Vec3& x) {
            const double r = (x / kSpacing - half + Vec3::Constant(0.5)).cwiseQuotient(half).norm();
            return r > 1.05 || r < 0.3;
        });
    for (Vec3& x : X) x = Vec3(x[(2 - axis + 3) % 3], x[(3 - axis + 3) % 3], x[(4 - axis + 3) % 3]);
    return X;
}
