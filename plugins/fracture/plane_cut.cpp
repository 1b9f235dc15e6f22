/*! Fracture of Lyu, Zhang, Chang, Guo, Zhang 2019, section 3.4: bonds in question are gathered into deformed areas, and each area
    is cut along one plane. Equation numbers are the paper's.
      screen   (12) l = (e - e_p)/(|X| (1 + p_inactive)) > threshold   e = (|Y| - |X|)/|X|: `measure = "paper"`, l in 1/m, so
                                                                     that it depends on resolution; "strain": without 1/|X|
      cluster  particles of screened bonds, each with the direction of its most deformed one, make one area when they are
               nearer than `reach` and their directions within `angle`, and so on from one to the next (single linkage)
      plane    through the area's centre, across its most deformed bond; as long and wide as its particles lie
      cut      every live bond that crosses it
    p_inactive is the share of broken bonds among all bonds of the particles in the same grid cell (here of edge `reach` where
    there is no grid): damage gathers in few cracks. It only lowers l, so that screening by blocks may leave it to `decide`.
    e_p is taken as 0: laws keep permanent strains to themselves. */
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>

#include "perimpm/geometry/patch.hpp"
#include "perimpm/peridynamics/family.hpp"
#include "perimpm/plugin/plugin.hpp"

namespace {
using namespace perimpm;
using namespace perimpm::peridynamics;

constexpr ParamSpec kParams[] = {
    {.key = "threshold",
     .unit = "1/m or 1",
     .range = above(0),
     .doc = "deformation l above which a bond is in question: [1/m] for measure \"paper\", a strain for \"strain\""},
    {.key = "measure",
     .kind = ParamKind::choice,
     .default_text = "strain",
     .choices = "paper|strain",
     .doc = "strain over the bond's length, as printed, or strain alone, whatever the resolution"},
    {.key = "p_inactive",
     .kind = ParamKind::boolean,
     .default_value = 1,
     .doc = "whether bonds among broken ones are in question later"},
    {.key = "reach",
     .unit = "spacings",
     .range = above(0),
     .default_value = 2,
     .doc = "particles of one deformed area are at most that far from the next"},
    {.key = "angle",
     .unit = "deg",
     .range = open(0, 90),
     .default_value = 45,
     .doc = "and their directions differ by less"},
    interval_param(),
};

using Cell = std::array<std::int64_t, 3>;
Cell cell_of(const Vec3& x, double width) {
    Cell c;
    for (int a = 0; a < 3; ++a) c[static_cast<std::size_t>(a)] = static_cast<std::int64_t>(std::floor(x[a] / width));
    return c;
}

/// A particle with bonds in question, and the most deformed of them.
struct Deformed {
    std::uint32_t particle;
    Vec3 x, direction;
    Vec3 middle;         ///< of the bond [m]
    double deformation;  ///< l
};

template <class Real>
class PlaneCut final : public FractureCriterion<Real> {
    using P = Pack<Real>;

public:
    explicit PlaneCut(const Params& p)
        : threshold_{p["threshold"]},
          by_length_{p.is("measure", "paper")},
          damage_slows_{p.flag("p_inactive")},
          reach_{p["reach"] * p.context().particle_spacing},
          cell_{p.context().grid_spacing > 0 ? p.context().grid_spacing : reach_},
          aligned_{std::cos(p["angle"] * std::numbers::pi / 180)},
          spacing_{p.context().particle_spacing},
          interval_{static_cast<std::uint32_t>(p["interval"])} {}
    std::uint32_t interval() const noexcept override { return interval_; }
    /// A short bond reaches any l in 1/m at little stretch.
    double harmless_stretch() const noexcept override { return by_length_ ? 0 : threshold_ * (1 - 1e-6); }

    /// (12) without p_inactive.
    void screen(const Block<Real>& b, CandidateList& found) const override {
        const P threshold(static_cast<Real>(threshold_));
        for (std::uint32_t i = 0; i < b.size; ++i) {
            const Real* own = b.family.position + 4 * std::size_t{b.first + i};
            for_each_bond(b, i, [&](const BondPack<Real>& bonds, const P& live) PERIMPM_INLINE_LAMBDA {
                P Y[3];
                bonds.difference(b.family.position, own, Y);
                const P X = bonds.length();
                const P limit = by_length_ ? threshold * X * X : threshold * X;
                const auto over = live > P(0) && norm(Y) - X > limit;
                if (any_of(over))
                    for (std::uint32_t lane = 0; lane < bonds.size; ++lane)
                        if (over[lane]) found.add(b.first + i, bonds.slot + lane);
            });
        }
    }

    void decide(const Block<Real>& all, std::span<const BondCandidate> found,
                std::vector<BondCandidate>& cuts) const override {
        const std::vector<Deformed> deformed = most_deformed(all, found);
        if (deformed.empty()) return;
        const std::vector<Patch> planes = planes_of(deformed, areas_of(deformed));
        cut(all, planes, longest_bond(all, found), cuts);
    }

private:
    static Vec3 position(const Block<Real>& all, std::uint32_t p) {
        const Real* x = all.family.position + 4 * std::size_t{p};
        return {static_cast<double>(x[0]), static_cast<double>(x[1]), static_cast<double>(x[2])};
    }

    /// The particles whose bonds (12) puts in question, each with the worst of them.
    std::vector<Deformed> most_deformed(const Block<Real>& all, std::span<const BondCandidate> found) const {
        const std::map<Cell, double> inactive = inactive_shares(all, found);
        std::vector<Deformed> list;
        for (const auto& [p, slot] : found) {
            const Vec3 x = position(all, p), other = position(all, all.family.neighbour[slot]);
            const double X = static_cast<double>(all.family.length[constant_of(all.family, p, slot)]),
                         Y = (other - x).norm();
            const double share = damage_slows_ ? inactive.at(cell_of(x, cell_)) : 0.0;
            const double l = (Y - X) / (by_length_ ? X * X : X) / (1 + share);  // (12)
            if (l <= threshold_) continue;
            if (list.empty() || list.back().particle != p)
                list.push_back({p, x, {}, {}, 0});
            else if (l <= list.back().deformation)
                continue;
            Deformed& d = list.back();
            d.direction = (other - x) / Y, d.middle = 0.5 * (x + other), d.deformation = l;
        }
        return list;
    }

    /// p_inactive of the cells that hold screened particles.
    std::map<Cell, double> inactive_shares(const Block<Real>& all, std::span<const BondCandidate> found) const {
        std::map<Cell, double> share;
        if (!damage_slows_) return share;
        std::map<Cell, std::pair<double, double>> bonds;  // broken, all
        for (const BondCandidate& c : found) bonds.try_emplace(cell_of(position(all, c.particle), cell_));
        for (std::uint32_t p = 0; p < all.size; ++p) {
            const auto in = bonds.find(cell_of(position(all, p), cell_));
            if (in == bonds.end()) continue;
            in->second.first += all.family.damage[p];
            in->second.second += all.family.row[p + 1] - all.family.row[p];
        }
        for (const auto& [cell, counts] : bonds) share[cell] = counts.first / counts.second;
        return share;
    }

    /// The deformed particles by areas: single linkage over pairs that are near and aligned.
    std::vector<std::vector<std::uint32_t>> areas_of(const std::vector<Deformed>& deformed) const {
        std::map<Cell, std::vector<std::uint32_t>> cells;
        std::vector<std::uint32_t> parent(deformed.size());
        std::iota(parent.begin(), parent.end(), 0u);
        const auto root = [&](std::uint32_t k) {
            while (parent[k] != k) k = parent[k] = parent[parent[k]];
            return k;
        };
        for (std::uint32_t k = 0; k < deformed.size(); ++k) {
            const Cell home = cell_of(deformed[k].x, reach_);
            for (std::int64_t n = 0; n < 27; ++n) {
                const auto around = cells.find({home[0] + n / 9 - 1, home[1] + n / 3 % 3 - 1, home[2] + n % 3 - 1});
                if (around == cells.end()) continue;
                for (const std::uint32_t other : around->second) {
                    if ((deformed[k].x - deformed[other].x).norm() > reach_ ||
                        std::abs(deformed[k].direction.dot(deformed[other].direction)) < aligned_)
                        continue;
                    const std::uint32_t a = root(k), c = root(other);
                    parent[std::max(a, c)] = std::min(a, c);
                }
            }
            cells[home].push_back(k);
        }
        std::map<std::uint32_t, std::vector<std::uint32_t>> areas;
        for (std::uint32_t k = 0; k < deformed.size(); ++k) areas[root(k)].push_back(k);
        std::vector<std::vector<std::uint32_t>> list;
        for (auto& [first, members] : areas) list.push_back(std::move(members));
        return list;
    }

    /// One rectangle per area: through its centre, across its most deformed bond, as long and wide as its particles lie.
    std::vector<Patch> planes_of(const std::vector<Deformed>& deformed,
                                 const std::vector<std::vector<std::uint32_t>>& areas) const {
        std::vector<Patch> planes;
        for (const std::vector<std::uint32_t>& area : areas) {
            Vec3 center = Vec3::Zero();
            for (const std::uint32_t k : area) center += deformed[k].middle / static_cast<double>(area.size());
            const Deformed& worst = deformed[*std::max_element(area.begin(), area.end(), [&](auto a, auto c) {
                return deformed[a].deformation < deformed[c].deformation;
            })];
            const Vec3 normal = worst.direction;
            Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
            for (const std::uint32_t k : area) {
                const Vec3 to = deformed[k].x - center, within = to - to.dot(normal) * normal;
                spread += within * within.transpose();
            }
            const Vec3 u = longest_axis(spread, normal), v = normal.cross(u);
            Eigen::AlignedBox2d extent;
            for (const std::uint32_t k : area)
                extent.extend(Eigen::Vector2d((deformed[k].x - center).dot(u), (deformed[k].x - center).dot(v)));
            const Eigen::Vector2d low = extent.min().array() - spacing_ / 2, high = extent.max().array() + spacing_ / 2;
            planes.push_back({.origin = center + low[0] * u + low[1] * v,
                              .normal = normal,
                              .edge_u = (high[0] - low[0]) * u,
                              .edge_v = (high[1] - low[1]) * v});
        }
        return planes;
    }

    /// Unit vector across the normal along which the area is longest.
    static Vec3 longest_axis(const Eigen::Matrix3d& spread, const Vec3& normal) {
        const Vec3 longest = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvectors().col(2);
        const Vec3 within = longest - longest.dot(normal) * normal;
        return within.norm() > 0.5 ? within.normalized() : normal.unitOrthogonal();
    }

    /// Bound of |Y|: (12) was not met by the bonds that were not found.
    double longest_bond(const Block<Real>& all, std::span<const BondCandidate> found) const {
        double X = 0, Y = 0;
        for (const auto& [p, slot] : found) {
            Y = std::max(Y, (position(all, all.family.neighbour[slot]) - position(all, p)).norm());
            for (std::uint32_t k = all.family.row[p]; k < all.family.row[p + 1]; ++k)
                X = std::max(X, static_cast<double>(all.family.length[constant_of(all.family, p, k)]));
        }
        return std::max(Y, X * (1 + (by_length_ ? threshold_ * X : threshold_)));
    }

    /// Live bonds that cross a plane.
    void cut(const Block<Real>& all, const std::vector<Patch>& planes, double longest,
             std::vector<BondCandidate>& cuts) const {
        std::vector<const Patch*> near;
        for (std::uint32_t p = 0; p < all.size; ++p) {
            const Vec3 x = position(all, p);
            near.clear();
            for (const Patch& plane : planes) {
                const Vec3 middle = plane.origin + (plane.edge_u + plane.edge_v) / 2;
                const double about = (plane.edge_u + plane.edge_v).norm() / 2 + longest;
                if ((x - middle).squaredNorm() <= about * about) near.push_back(&plane);
            }
            for (std::uint32_t slot = all.family.row[p]; slot < all.family.row[p + 1] && !near.empty(); ++slot) {
                const std::uint32_t q = all.family.neighbour[slot];
                if (q < p || all.family.is_broken(slot)) continue;
                const Vec3 other = position(all, q);
                if (std::any_of(near.begin(), near.end(), [&](const Patch* plane) { return plane->crosses(x, other); }))
                    cuts.push_back({p, slot});
            }
        }
    }

    double threshold_;
    bool by_length_, damage_slows_;
    double reach_, cell_, aligned_, spacing_;
    std::uint32_t interval_;
};
}  // namespace

PERIMPM_PLUGIN(FractureCriterion, PlaneCut, kParams,
               "deformed areas are cut along planes: fragments of many particles (Lyu et al. 2019)")
