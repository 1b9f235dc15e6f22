/*! Stiffness as particles have it. W(e), the energy per volume of a particle under the affine strain e, is e C e/2 for
    small e:
      (1) C_ii = 2 W(e_i),  C_ij = W(e_i + e_j) - W(e_i) - W(e_j)    e_i: unit strains in Voigt's order
      (2) W(e) = [W(+s e) + W(-s e) - 2 W(0)]/(2 s^2)                odd orders cancel */
#include "perimpm/step/stiffness.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "perimpm/math/stiffness.hpp"
#include "step/stages.hpp"

namespace perimpm {

namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// Families with |sum V X| below this share of sum V |X| have no side on which neighbours are missing.
double balance_limit(const World<double>& w, std::uint32_t material) {
    const auto irregular = [&](const BodySpec& b) { return b.material == material && b.poisson; };
    return std::any_of(w.scene.bodies.begin(), w.scene.bodies.end(), irregular) ? 0.1 : 1e-4;
}

/// densities(F): by particle, the energy per volume under the affine deformation F [J/m^3]. s: see (2).
template <class Densities>
std::vector<Stiffness> stiffness_from(double s, const Densities& densities) {
    const auto under = [&](const VoigtStrain& e) {
        return densities(Eigen::Matrix3d(Eigen::Matrix3d::Identity() + strain_of(e)));
    };
    const std::vector<double> rest = under(VoigtStrain::Zero());
    const auto along = [&](const VoigtStrain& e) {
        std::vector<double> W = under(s * e);
        const std::vector<double> other = under(-s * e);
        for (std::size_t p = 0; p < W.size(); ++p) W[p] = (W[p] + other[p] - 2 * rest[p]) / (2 * s * s);  // (2)
        return W;
    };
    std::vector<Stiffness> found(rest.size(), Stiffness::Zero());
    for (int i = 0; i < 6; ++i) {
        const std::vector<double> W = along(VoigtStrain::Unit(i));
        for (std::size_t p = 0; p < W.size(); ++p) found[p](i, i) = 2 * W[p];  // (1)
    }
    for (int i = 0; i < 6; ++i)
        for (int j = 0; j < i; ++j) {
            const std::vector<double> W = along(VoigtStrain::Unit(i) + VoigtStrain::Unit(j));
            for (std::size_t p = 0; p < W.size(); ++p) {
                Stiffness& C = found[p];
                C(i, j) = C(j, i) = W[p] - (C(i, i) + C(j, j)) / 2;
            }
        }
    return found;
}

std::vector<double> family_densities(World<double>& w, Material<double>& m, const Eigen::Matrix3d& F) {
    for (std::size_t p = 0; p < m.size; ++p) {
        const double* X = m.reference.data() + 4 * p;
        const Vec3 x = F * Vec3(X[0], X[1], X[2]);
        for (int c = 0; c < 3; ++c) w.x[static_cast<std::size_t>(c)][m.begin + p] = x[c];
    }
    pack_positions(w, m);
    if (m.needs.prepare) for_each_chunk(w, m, [&](std::size_t, Block<double>& b) { m.law->prepare(b); });
    std::vector<double> found(m.size);
    w.threads.run(m.size,
                  [&](std::size_t p) { found[p] = m.law->energy(make_block(w, m, p, 1)) / w.volume[m.begin + p]; });
    return found;
}

/// Of the first particle, for which all stand: parameters that vary count as the law was made with.
double local_density(World<double>& w, Material<double>& m, const Eigen::Matrix3d& F) {
    for (int c = 0; c < 9; ++c) m.F[static_cast<std::size_t>(c)][0] = F(c / 3, c % 3);
    Block<double> b = make_block(w, m, 0, 1);
    for (const double*& values : b.param) values = nullptr;
    return m.law->energy(b) / w.volume[m.begin];
}

/// |sum V X|/sum V |X| over the family; 1 for a particle without bonds.
double imbalance(const Material<double>& m, std::size_t p) {
    Vec3 sum = Vec3::Zero();
    double whole = 0;
    const double* own = m.reference.data() + 4 * p;
    for (std::uint32_t slot = m.bonds.row[p]; slot < m.bonds.row[p + 1]; ++slot) {
        const double* q = m.reference.data() + 4 * std::size_t{m.bonds.neighbour[slot]};
        sum += q[3] * Vec3(q[0] - own[0], q[1] - own[1], q[2] - own[2]);
        whole += q[3] * m.constants.length[m.constants.shape[p] + slot - m.bonds.row[p]];
    }
    return whole > 0 ? sum.norm() / whole : 1;
}

/// By particle, whether it lies in the bulk: its family and those of all its neighbours are balanced, so that no weight
/// knows of a surface. In a body too thin for that, whether its own family is.
std::vector<char> bulk_of(const Material<double>& m, double limit) {
    std::vector<char> balanced(m.size), deep(m.size);
    for (std::size_t p = 0; p < m.size; ++p) balanced[p] = imbalance(m, p) <= limit;
    const std::uint32_t* neighbour = m.bonds.neighbour.data();
    for (std::size_t p = 0; p < m.size; ++p)
        deep[p] = balanced[p] && std::all_of(neighbour + m.bonds.row[p], neighbour + m.bonds.row[p + 1],
                                             [&](std::uint32_t q) { return balanced[q]; });
    return std::find(deep.begin(), deep.end(), 1) == deep.end() ? balanced : deep;
}

FamilyStiffness stiffness_of(const Stiffness& C) {
    if (!C.allFinite() || C.isZero(0)) return {kNone, kNone, kNone, kNone};
    const Eigen::Matrix3Xd basis = resisting_directions(C);
    const IsotropicAverage average = isotropic_average(C, std::max(1, static_cast<int>(basis.cols())));
    FamilyStiffness s{average.youngs_modulus(), average.poisson_ratio(), std::numeric_limits<double>::infinity(),
                      -std::numeric_limits<double>::infinity()};
    const DirectionalModulus modulus(C);
    for (const Vec3& n : directions_in(basis)) {
        const double E = modulus(n);
        s.softest = std::min(s.softest, E), s.stiffest = std::max(s.stiffest, E);
    }
    return s;
}

MeasuredStiffness of_local_law(World<double>& w, Material<double>& m, const MeasuredStiffness& asked) {
    constexpr double kStrain = 1e-5;  // a law's energy need not be exact near rest, and a soft one may yield
    MeasuredStiffness s = asked;
    s.bulk_particles = m.size;
    s.bulk = stiffness_of(stiffness_from(
        kStrain, [&](const Eigen::Matrix3d& F) { return std::vector<double>{local_density(w, m, F)}; })[0]);
    s.unstable_particles = s.bulk.softest < 0 ? m.size : 0;
    return s;
}

MeasuredStiffness of_families(World<double>& w, Material<double>& m, double limit, const MeasuredStiffness& asked) {
    MeasuredStiffness s = asked;
    const std::vector<Stiffness> stiffness =
        stiffness_from(1e-6, [&](const Eigen::Matrix3d& F) { return family_densities(w, m, F); });
    family_densities(w, m, Eigen::Matrix3d::Identity());  // back to rest
    std::vector<FamilyStiffness> each(m.size);
    w.threads.run(m.size, [&](std::size_t p) { each[p] = stiffness_of(stiffness[p]); });
    FamilyStiffness sum{0, 0, std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
    const std::vector<char> in_bulk = bulk_of(m, limit);
    double worst = -1;
    for (std::size_t p = 0; p < m.size; ++p) {
        const FamilyStiffness& own = each[p];
        s.unstable_particles += own.softest < 0;
        if (in_bulk[p]) {
            ++s.bulk_particles;
            sum.youngs_modulus += own.youngs_modulus, sum.poisson_ratio += own.poisson_ratio;
            sum.softest = std::min(sum.softest, own.softest), sum.stiffest = std::max(sum.stiffest, own.stiffest);
            continue;
        }
        ++s.surface_particles;
        const double off = std::max(s.youngs_modulus - own.softest, own.stiffest - s.youngs_modulus);
        if (!(off > worst)) continue;
        worst = off, s.worst = own;
        s.worst_position = Vec3(m.reference.data() + 4 * p);
    }
    if (s.bulk_particles == 0) return s;
    const auto n = static_cast<double>(s.bulk_particles);
    s.bulk = {sum.youngs_modulus / n, sum.poisson_ratio / n, sum.softest, sum.stiffest};
    return s;
}

/// Longitudinal modulus over Young's modulus in as many dimensions.
double uniaxial_share(double nu, double d) { return (1 - (d - 2) * nu) / ((1 + nu) * (1 - (d - 1) * nu)); }

}  // namespace

std::vector<MeasuredStiffness> measure_stiffness(Scene scene, int threads) {
    scene.simulation.precision = Precision::double_;
    World<double> w(std::move(scene), threads);
    build_world(w);
    std::vector<MeasuredStiffness> found;
    for (Material<double>& m : w.materials) {
        const auto spec = std::find_if(w.scene.materials.begin(), w.scene.materials.end(),
                                       [&](const MaterialSpec& s) { return s.name == m.name; });
        const auto index = static_cast<std::uint32_t>(spec - w.scene.materials.begin());
        const FamilyStiffness none{kNone, kNone, kNone, kNone};
        MeasuredStiffness asked{.material = m.name,
                                .dimension = m.dimension,
                                .youngs_modulus = m.needs.moduli.youngs_modulus,
                                .poisson_ratio = m.needs.moduli.poisson_ratio,
                                .bulk_particles = 0,
                                .bulk = none,
                                .wave_speed = kNone,
                                .surface_particles = 0,
                                .worst = none,
                                .worst_position = Vec3::Constant(kNone),
                                .unstable_particles = 0};
        MeasuredStiffness& s = found.emplace_back(m.has_bonds() ? of_families(w, m, balance_limit(w, index), asked)
                                                                : of_local_law(w, m, asked));
        const double d = s.dimension, share = d > 1 ? uniaxial_share(s.bulk.poisson_ratio, d) : 1;
        s.wave_speed = std::sqrt(share * s.bulk.youngs_modulus / m.density);
    }
    return found;
}

}  // namespace perimpm
