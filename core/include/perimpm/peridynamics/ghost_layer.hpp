#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

#include "perimpm/model/block.hpp"

/*! Ghost particles of Lyu et al. 2019 (section 6, Implementation): on the sites of the lattice around a particle that are
    empty because the body ends before them, "to guarantee that each material point have similar family density". The paper
    does not say how they move. Here a ghost's bond is stretched as the family's bonds on the same line through the particle
    are, or, where there are none, as at edges, those that are nearest in direction: a ghost is the image of particles in the
    family, and its energy is theirs. Nothing follows where no bond is within 60 degrees, as across a single layer: such sites
    stay empty. */
namespace perimpm::peridynamics {

struct Ghost {
    double length;                   ///< |X|
    std::vector<std::size_t> bonds;  ///< in the family: those that share its bond, alike
};

class GhostLayer {
public:
    GhostLayer(double spacing, double reach) : spacing_{spacing}, reach_{reach} {}

    double volume() const { return spacing_ * spacing_ * spacing_; }

    /// Of the block's particle i: on sites without a particle of the body within nine tenths of a spacing. In a lattice,
    /// however turned, the nearest one is at most sqrt(3)/2 away.
    template <class Real>
    std::vector<Ghost> of(const Block<Real>& b, std::uint32_t i) const {
        const std::vector<Eigen::Vector3d> family = family_of(b, b.first + i);
        const auto holds = [&](const std::vector<Eigen::Vector3d>& particles, const Eigen::Vector3d& site) {
            return std::any_of(particles.begin(), particles.end(),
                               [&](const Eigen::Vector3d& X) { return (X - site).norm() < 0.9 * spacing_; });
        };
        std::vector<Eigen::Vector3d> around;
        std::vector<Ghost> ghosts;
        const int most = static_cast<int>(reach_ / spacing_ * (1 + 1e-9));
        for (int x = -most; x <= most; ++x)
            for (int y = -most; y <= most; ++y)
                for (int z = -most; z <= most; ++z) {
                    const Eigen::Vector3d site = spacing_ * Eigen::Vector3d(x, y, z);
                    if (site.norm() > reach_ * (1 + 1e-9) || site.norm() < 0.9 * spacing_ || holds(family, site))
                        continue;
                    if (around.empty()) around = neighbours_of_neighbours(b, i, family);
                    std::vector<std::size_t> bonds = nearest_in_direction(family, site);
                    if (!bonds.empty() && !holds(around, site)) ghosts.push_back({site.norm(), std::move(bonds)});
                }
        return ghosts;
    }

private:
    /// X of the bonds of the material's particle p.
    template <class Real>
    static std::vector<Eigen::Vector3d> family_of(const Block<Real>& b, std::size_t p) {
        const std::uint32_t* row = b.family.row - b.first;  // of the whole material
        const Real* own = b.family.reference + 4 * p;
        std::vector<Eigen::Vector3d> X;
        for (std::uint32_t slot = row[p]; slot < row[p + 1]; ++slot) {
            const Real* other = b.family.reference + 4 * std::size_t{b.family.neighbour[slot]};
            X.emplace_back(other[0] - own[0], other[1] - own[1], other[2] - own[2]);
        }
        return X;
    }
    /// Particles just beyond the horizon fill sites at its rim.
    template <class Real>
    static std::vector<Eigen::Vector3d> neighbours_of_neighbours(const Block<Real>& b, std::uint32_t i,
                                                                 const std::vector<Eigen::Vector3d>& family) {
        std::vector<Eigen::Vector3d> all;
        for (std::size_t k = 0; k < family.size(); ++k)
            for (const Eigen::Vector3d& X : family_of(b, b.family.neighbour[b.family.row[i] + k]))
                all.push_back(family[k] + X);
        return all;
    }
    /// The bonds on the line, or nearest to it: as many as are equally near, so that mirror images share alike.
    static std::vector<std::size_t> nearest_in_direction(const std::vector<Eigen::Vector3d>& family,
                                                         const Eigen::Vector3d& X) {
        const auto cosine = [&](const Eigen::Vector3d& bond) {
            return std::abs(bond.dot(X)) / (bond.norm() * X.norm());
        };
        double largest = 0;
        for (const Eigen::Vector3d& bond : family) largest = std::max(largest, cosine(bond));
        std::vector<std::size_t> nearest;
        for (std::size_t k = 0; k < family.size() && largest >= 0.5; ++k)
            if (cosine(family[k]) >= largest - 1e-6) nearest.push_back(k);
        return nearest;
    }

    double spacing_, reach_;
};

}  // namespace perimpm::peridynamics
