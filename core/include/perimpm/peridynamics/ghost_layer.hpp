#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

#include "perimpm/peridynamics/influence.hpp"
#include "perimpm/peridynamics/weights.hpp"

/*! Ghost particles of Lyu et al. 2019 (section 6, Implementation): on the sites of the lattice around a particle that are
    empty because the body ends before them, "to guarantee that each material point have similar family density". The paper
    does not say how they move. Here a ghost follows the family that sees it, Y = F- X: its bond is an averaged bond, and what
    it pulls is the gradient of an energy, so that the family's particles pull back. How far an averaged bond is stretched
    depends on its direction alone: a ghost therefore counts as a share of the family's bonds on the same line through the
    particle, or, where there are none, as at edges, of those that are nearest in direction. Nothing follows where no bond is
    within 60 degrees, as across a single layer: such sites stay empty. */
namespace perimpm::peridynamics {

class GhostLayer {
public:
    /// `total`: what sum w_pq V_q is over family and ghosts; `scale`: stiffness of a ghost's bond over that of an averaged one.
    GhostLayer(const ModelContext& c, const Influence& influence, double total, double scale)
        : spacing_{c.particle_spacing}, influence_{influence}, total_{total}, scale_{scale} {}

    /// Where a law keeps what it has: constants S of the bonds, and S of the averaged bonds, which takes the ghosts' share.
    struct Fields {
        std::uint32_t normalisation, own, averaged;
    };
    /// Normalises the weights of the block's particle i with its ghosts, and adds their share.
    template <class Real>
    void complete(Block<Real>& b, std::uint32_t i, const Fields& at) const {
        const std::vector<Eigen::Vector3d> family = family_of(b, b.first + i);
        if (family.empty()) return;
        const std::vector<Eigen::Vector3d> ghosts = empty_sites(b, i, family);
        const double volume = spacing_ * spacing_ * spacing_;
        double sum = 0;
        for (std::uint32_t k = 0; k < family.size(); ++k)
            sum += influence_(family[k].norm()) *
                   static_cast<double>(b.family.volume[b.family.neighbour[b.family.row[i] + k]]);
        for (const Eigen::Vector3d& X : ghosts) sum += influence_(X.norm()) * volume;
        Real& normalisation = b.particle_state[at.normalisation][0][i];
        const double factor = total_ / sum, change = factor / static_cast<double>(normalisation);
        normalisation = static_cast<Real>(factor);
        Real* own = b.bond_constants[at.own] + b.family.shape[i];
        Real* averaged = b.bond_constants[at.averaged] + b.family.shape[i];
        for (std::size_t k = 0; k < family.size(); ++k) {
            own[k] = static_cast<Real>(change * static_cast<double>(own[k]));
            averaged[k] = own[k];
        }
        for (const Eigen::Vector3d& X : ghosts) {
            const std::vector<std::size_t> nearest = nearest_in_direction(family, X);
            const double weighted = factor * influence_(X.norm()) * static_cast<double>(b.volume[i]) * volume;
            for (const std::size_t k : nearest)
                averaged[k] += static_cast<Real>(scale_ * weighted / family[k].squaredNorm() /
                                                 static_cast<double>(nearest.size()));
        }
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
    /// Sites without a particle of the body within nine tenths of a spacing: in a lattice, however turned, the nearest one is
    /// at most sqrt(3)/2 away.
    template <class Real>
    std::vector<Eigen::Vector3d> empty_sites(const Block<Real>& b, std::uint32_t i,
                                             const std::vector<Eigen::Vector3d>& family) const {
        const auto holds = [&](const std::vector<Eigen::Vector3d>& particles, const Eigen::Vector3d& site) {
            return std::any_of(particles.begin(), particles.end(),
                               [&](const Eigen::Vector3d& X) { return (X - site).norm() < 0.9 * spacing_; });
        };
        std::vector<Eigen::Vector3d> sites, around;
        const int reach = static_cast<int>(influence_.reach() / spacing_ * (1 + 1e-9));
        for (int x = -reach; x <= reach; ++x)
            for (int y = -reach; y <= reach; ++y)
                for (int z = -reach; z <= reach; ++z) {
                    const Eigen::Vector3d site = spacing_ * Eigen::Vector3d(x, y, z);
                    if (site.norm() > influence_.reach() * (1 + 1e-9) || site.norm() < 0.9 * spacing_ ||
                        holds(family, site))
                        continue;
                    if (around.empty()) around = neighbours_of_neighbours(b, i);
                    if (!holds(around, site) && !nearest_in_direction(family, site).empty()) sites.push_back(site);
                }
        return sites;
    }
    /// Particles just beyond the horizon fill sites at its rim.
    template <class Real>
    static std::vector<Eigen::Vector3d> neighbours_of_neighbours(const Block<Real>& b, std::uint32_t i) {
        std::vector<Eigen::Vector3d> all;
        const std::vector<Eigen::Vector3d> family = family_of(b, b.first + i);
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

    double spacing_;
    Influence influence_;
    double total_, scale_;
};

}  // namespace perimpm::peridynamics
