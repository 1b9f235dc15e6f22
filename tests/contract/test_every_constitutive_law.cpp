// What holds for every installed law, found through the registry: a new plugin is tested the day it is installed.
#include <memory>

#include "support/every_model.hpp"
#include "support/particles.hpp"

using namespace perimpm;
using Eigen::Matrix3d;

namespace {

constexpr double kSpacing = 0.01, kVolume = kSpacing * kSpacing * kSpacing;
constexpr int kCount = 7;

template <class Real = double>
struct Sample {
    ModelPtr<ConstitutiveLaw, Real> law;
    Particles<Real> particles;

    explicit Sample(const std::string& name, const std::string& more = "")
        : law{make<ConstitutiveLaw, Real>(
              name, smallest_table(Family::constitutive, name) + more,
              {.density = 1000, .particle_spacing = kSpacing, .grid_spacing = 2 * kSpacing})},
          particles{*law, lattice(kCount, kSpacing), kVolume} {}

    bool is_local() const { return law->needs().deformation_gradient; }
    /// A homogeneous deformation: F everywhere, positions as well.
    void deform(const Matrix3d& F) {
        particles.deform(F);
        for (std::size_t p = 0; p < particles.size() && is_local(); ++p) particles.set_F(p, F);
    }
    /// Another deformation at every particle.
    void scramble(unsigned seed) {
        std::mt19937 random(seed);
        std::uniform_real_distribution<double> shift(-0.1 * kSpacing, 0.1 * kSpacing);
        particles.move([&](const Vec3& X) -> Vec3 { return X + Vec3(shift(random), shift(random), shift(random)); });
        for (std::size_t p = 0; p < particles.size() && is_local(); ++p)
            particles.set_F(p, Matrix3d::Identity() + 0.2 * random_matrix(random));
    }
    /// Stresses [Pa], or forces over h^2 [Pa], as one vector per particle.
    std::vector<Eigen::VectorXd> response(std::size_t chunk = ~std::size_t{0}) {
        particles.evaluate(chunk);
        std::vector<Eigen::VectorXd> r;
        for (std::size_t p = 0; p < particles.size(); ++p) {
            if (is_local())
                r.emplace_back(particles.tau(p).reshaped());
            else
                r.emplace_back(particles.force(p) / (kSpacing * kSpacing));
        }
        return r;
    }
};

double largest(const std::vector<Eigen::VectorXd>& r) {
    double size = 0;
    for (const Eigen::VectorXd& v : r) size = std::max(size, v.norm());
    return size;
}

}  // namespace

TEMPLATE_TEST_CASE("every law: no stress and no energy at rest", "[contract]", float, double) {
    const double rounding = static_cast<double>(std::numeric_limits<TestType>::epsilon());
    for (const std::string& name : names_of(Family::constitutive)) {
        CAPTURE(name);
        Sample<TestType> sample(name);
        CHECK(largest(sample.response()) <= 10 * rounding * 1e6);
        const double energy = sample.particles.energy();
        if (!std::isnan(energy))
            CHECK(std::abs(energy) <=
                  100 * rounding * rounding * 1e6 * kVolume * static_cast<double>(sample.particles.size()));
    }
}

TEMPLATE_TEST_CASE("every law: forces and stresses are finite, whatever family is last", "[contract]", float, double) {
    for (const std::string& name : names_of(Family::constitutive)) {
        const PluginDescriptor& d = *open_plugin(Family::constitutive, name).descriptor;
        const auto declares = [&](const std::string& key) {
            return std::any_of(d.params, d.params + d.param_count, [&](const ParamSpec& p) { return p.key == key; });
        };
        std::vector<std::string> tables{""};
        const auto vary = [&](const std::string& key, const std::vector<std::string>& values) {
            if (!declares(key)) return;
            const std::vector<std::string> before = std::exchange(tables, {});
            for (const std::string& table : before)
                for (const std::string& value : values) tables.push_back(fmt::format("{}{} = {}\n", table, key, value));
        };
        vary("surface", {"\"none\"", "\"family\"", "\"moment\""});
        vary("formulation", {"\"variational\"", "\"paper\""});
        vary("horizon", {"1.01", "1.8", "2.01", "3.015"});
        for (const std::string& table : tables) {
            CAPTURE(name, table);
            Sample<TestType> sample(name, table);
            sample.scramble(1);
            const auto response = sample.response();
            CHECK(std::all_of(response.begin(), response.end(), [](const auto& v) { return v.allFinite(); }));
        }
    }
}

namespace {

/// Particles of a box, or of an ellipsoid, whose rows begin and end anywhere.
std::vector<Vec3> rows_of(bool is_box, double h) {
    std::vector<Vec3> X = rows_of_particles(7, 60, h);
    if (!is_box)
        std::erase_if(X,
                      [&](const Vec3& x) { return (x / h - Vec3(3, 3, 30)).cwiseQuotient(Vec3(4, 4, 28)).norm() > 1; });
    return X;
}

/// With broken bonds in the middle, if they `break`, and two steps of random displacements: what yields in the first is felt in the second.
template <class Real>
std::unique_ptr<Particles<Real>> deformed(const ConstitutiveLaw<Real>& law, const std::vector<Vec3>& X, double h,
                                          bool in_slices, bool in_rows, bool breaks, std::size_t chunk = 128) {
    const auto middle = static_cast<std::uint32_t>(std::find(X.begin(), X.end(), Vec3(h * Vec3(3, 3, 20))) - X.begin());
    REQUIRE(middle < X.size());
    auto particles = std::make_unique<Particles<Real>>(law, X, h * h * h);
    particles->in_slices = in_slices, particles->in_rows = in_rows, particles->may_break = breaks;
    Bonds& bonds = particles->bonds();
    for (std::uint32_t slot = bonds.row[middle]; slot < bonds.row[middle + 1] && breaks; slot += 3) {
        bonds.break_direction(bonds.neighbour[slot], bonds.opposite(middle, slot));
        bonds.break_direction(middle, slot);
    }
    if (breaks) particles->renew();
    std::mt19937 random(5);
    std::uniform_real_distribution<double> shift(-0.1 * h, 0.1 * h);
    for (int step = 0; step < 2; ++step) {
        particles->move([&](const Vec3& at) -> Vec3 { return at + Vec3(shift(random), shift(random), shift(random)); });
        particles->evaluate(chunk);
    }
    return particles;
}

}  // namespace

TEMPLATE_TEST_CASE("every law: families in lanes and families one by one have the same forces", "[contract]", float,
                   double) {
    // no power of two, so that products with it round
    const double h = 3.0 / 512, rounding = static_cast<double>(std::numeric_limits<TestType>::epsilon());
    int laws = 0;
    for (const std::string& name : names_of(Family::constitutive)) {
        std::vector<std::string> tables = {""};
        if (name == "pd_elastic" || name == "pd_bond" || name == "pd_lps")
            for (const char* surface : {"none", "family", "ghost"})
                tables.push_back(fmt::format("surface = \"{}\"\n", surface));
        if (name == "pd_elastic")
            for (const char* more : {"influence = \"constant\"\n", "bending_ratio = 0.0\n", "horizon = 1.01\n",
                                     "horizon = 3.015\n", "horizon = 4.3\n"})
                tables.push_back(more);
        if (name == "deviatoric_plastic" || name == "pd_lps")
            for (const char* rule : {"bond", "family"})
                tables.push_back(fmt::format("yield_stress = 1e4\nyield = \"{}\"\n", rule));
        if (name == "deviatoric_plastic")
            for (const char* more : {"surface = \"ghost\"\n", "horizon = 3.015\n"})
                tables.push_back(std::string("yield_stress = 1e4\n") + more);
        for (const std::string& table : tables) {
            const auto law =
                make<ConstitutiveLaw, TestType>(name, smallest_table(Family::constitutive, name) + table,
                                                {.density = 1000, .particle_spacing = h, .grid_spacing = 2 * h});
            if (law->needs().lanes == 0) continue;
            ++laws;
            for (const auto& [is_box, breaks] : {std::pair(true, true), {true, false}, {false, true}}) {
                CAPTURE(name, table, is_box, breaks);
                const std::vector<Vec3> X = rows_of(is_box, h);
                const auto single = deformed(*law, X, h, false, false, breaks);
                const double size = single->largest_force();
                CHECK(size > 0);
                for (const bool in_rows : {false, true}) {
                    CAPTURE(in_rows);
                    const auto lanes = deformed(*law, X, h, true, in_rows, breaks);
                    const auto [slices, all] = lanes->slices();
                    const bool is_far = law->needs().horizon > 3 * h;  // more neighbours lie before the first particle
                    CHECK(slices >= (!is_box ? all / 3 : is_far ? all * 3 / 4 : all * 9 / 10));
                    CHECK(lanes->in_lattice_rows() >= (law->needs().rows && is_far ? X.size() * 3 / 4 : 0));
                    for (std::uint32_t p = 0; p < X.size(); ++p)
                        REQUIRE((lanes->force(p) - single->force(p)).norm() <= 100 * rounding * size);
                    CHECK_THAT(double(lanes->largest_stretch),
                               WithinRel(double(single->largest_stretch), 10 * rounding));
                    const auto cut = deformed(*law, X, h, true, in_rows, breaks, 48);
                    for (std::uint32_t p = 0; p < X.size(); ++p) REQUIRE(cut->force(p) == lanes->force(p));
                }
            }
        }
    }
    CHECK(laws >= 18);  // the tables of pd_bond, pd_elastic, pd_lps and deviatoric_plastic
}

TEST_CASE("every law: a rotation changes nothing but the frame", "[contract]") {
    Matrix3d F;
    F << 1.2, 0.1, 0.0, -0.2, 0.9, 0.3, 0.1, 0.0, 1.1;
    for (const std::string& name : names_of(Family::constitutive)) {
        CAPTURE(name);
        Sample sample(name);
        sample.deform(F);
        const auto before = sample.response();
        const double energy = sample.particles.energy(), scale = largest(before);
        REQUIRE(scale > 0);
        for (const double angle : {0.4, 2.5}) {
            const Matrix3d R = rotation(angle, {1, 3, -2});
            sample.deform(R * F);
            const auto after = sample.response();
            for (std::size_t p = 0; p < before.size(); ++p) {
                const Eigen::VectorXd turned =
                    sample.is_local() ? Eigen::VectorXd((R * before[p].reshaped(3, 3) * R.transpose()).reshaped())
                                      : Eigen::VectorXd(R * before[p]);
                CHECK((after[p] - turned).norm() <= 1e-12 * scale);
            }
            if (!std::isnan(energy)) CHECK_THAT(sample.particles.energy(), WithinRel(energy, 1e-12));
        }
    }
}

TEST_CASE("every law: stress or force is the energy's derivative", "[contract]") {
    for (const std::string& name : names_of(Family::constitutive)) {
        CAPTURE(name);
        Sample sample(name);
        sample.scramble(11);
        Particles<double>& particles = sample.particles;
        if (std::isnan(particles.energy())) continue;
        const auto response = sample.response();
        const double scale = largest(response), step = 1e-5;
        const std::size_t p = middle(kCount);
        const Block<double> at = particles.block(p, 1);
        if (sample.is_local()) {
            Matrix3d F, P;
            for (int c = 0; c < 9; ++c) F(c / 3, c % 3) = at.F[static_cast<std::size_t>(c)][0];
            for (int c = 0; c < 9; ++c) {
                const auto energy = [&](double by) {
                    Matrix3d moved = F;
                    moved(c / 3, c % 3) += by;
                    particles.set_F(p, moved);
                    return particles.energy(p, 1);
                };
                P(c / 3, c % 3) = (energy(step) - energy(-step)) / (2 * step * kVolume);
            }
            const Matrix3d tau = P * F.transpose();
            CHECK((tau - response[p].reshaped(3, 3)).norm() <= 1e-6 * scale);
            continue;
        }
        const Vec3 y(at.x[0][0], at.x[1][0], at.x[2][0]);
        for (int c = 0; c < 3; ++c) {
            const auto energy = [&](double by) {
                particles.place(p, y + by * Vec3::Unit(c));
                return particles.energy();
            };
            const double force = -(energy(step * kSpacing) - energy(-step * kSpacing)) / (2 * step * kSpacing);
            CHECK_THAT(force / (kSpacing * kSpacing), WithinAbs(response[p][c], 1e-6 * scale));
            particles.place(p, y);
        }
    }
}

TEMPLATE_TEST_CASE("every law: any split into blocks gives the same response", "[contract]", float, double) {
    for (const std::string& name : names_of(Family::constitutive)) {
        CAPTURE(name);
        Sample<TestType> sample(name);
        sample.scramble(12);
        const auto whole = sample.response();
        // Lanes are filled differently, which may round differently in laws that sum over packs of particles.
        const double tolerance = 8 * static_cast<double>(std::numeric_limits<TestType>::epsilon()) * largest(whole);
        for (const std::size_t chunk : {std::size_t{1}, std::size_t{7}, std::size_t{128}}) {
            const auto parts = sample.response(chunk);
            for (std::size_t p = 0; p < whole.size(); ++p) CHECK((parts[p] - whole[p]).norm() <= tolerance);
        }
        const double energy = sample.particles.energy();
        double sum = 0;
        for (std::size_t p = 0; p < whole.size(); ++p) sum += sample.particles.energy(p, 1);
        if (!std::isnan(energy)) CHECK_THAT(sum, WithinRel(energy, 1e-4 * (sizeof(TestType) == 4 ? 1 : 1e-8)));
    }
}

TEMPLATE_TEST_CASE("every law: bounds of wave speed and time step are positive and finite", "[contract]", float,
                   double) {
    for (const std::string& name : names_of(Family::constitutive)) {
        CAPTURE(name);
        Sample<TestType> sample(name);
        const EffectiveModuli moduli = sample.law->needs().moduli;
        const double c = sample.law->max_wave_speed(sample.particles.block());
        CHECK((std::isfinite(c) && c > 0));
        if (!std::isnan(moduli.youngs_modulus))
            CHECK(c >= std::sqrt(moduli.youngs_modulus / 1000));  // a bar's waves are slower
        const auto [dt, any] = sample.law->stable_step(sample.particles.block());
        CHECK((any > 0 && any <= dt));
        if (!sample.is_local()) CHECK((std::isfinite(dt) && dt * c < 2 * kSpacing));
    }
}

TEST_CASE("every law: asks for a deformation gradient or for bonds, never both", "[contract]") {
    for (const std::string& name : names_of(Family::constitutive)) {
        CAPTURE(name);
        const LawNeeds needs = Sample(name).law->needs();
        CHECK(needs.deformation_gradient != needs.bonds);
        CHECK((needs.horizon > 0) == needs.bonds);
        CHECK(needs.rounds >= 1);
        CHECK(needs.particle_state.size <= kMaxStateFields);
        CHECK(needs.bond_state.size <= kMaxStateFields);
        CHECK(needs.bond_constants.size <= kMaxStateFields);
        check_fields(needs.particle_state);
        check_fields(needs.bond_state);
        check_fields(needs.bond_constants);
    }
}

TEST_CASE("every law: declared keys have unit and text, misspelt ones a suggestion", "[contract]") {
    for (const std::string& name : names_of(Family::constitutive)) {
        CAPTURE(name);
        check_declaration(Family::constitutive, name);
    }
}

TEST_CASE("every law: what it stores in bonds adds up to its energy, family by family", "[contract][fracture]") {
    std::size_t laws = 0;
    for (const std::string& name : names_of(Family::constitutive)) {
        std::vector<std::string> tables = {""};
        if (name == "pd_elastic" || name == "deviatoric_plastic") tables.push_back("formulation = \"paper\"\n");
        if (name == "pd_elastic" || name == "pd_bond" || name == "pd_lps") {
            tables.push_back("surface = \"none\"\n");
            tables.push_back("surface = \"family\"\nvolume_correction = \"linear\"\n");
        }
        if (name == "pd_elastic") tables.push_back("bending_ratio = 0.0\n");
        for (const char* rule : {"bond", "family"})
            if (name == "pd_lps") tables.push_back(fmt::format("yield_stress = 1e4\nyield = \"{}\"\n", rule));
        for (const std::string& table : tables) {
            CAPTURE(name, table);
            Sample sample(name, table);
            if (!sample.law->needs().stores_in_bonds) continue;
            ++laws;
            Particles<double>& particles = sample.particles;
            Bonds& bonds = particles.bonds();
            for (std::uint32_t p : {0u, 100u, 171u})  // a corner, and one within
                for (std::uint32_t slot = bonds.row[p]; slot < bonds.row[p + 1]; slot += 3) {
                    bonds.break_direction(bonds.neighbour[slot], bonds.opposite(p, slot));
                    bonds.break_direction(p, slot);
                }
            particles.renew();
            sample.scramble(3);
            particles.evaluate();
            const auto ends = particles.bond_energies();
            CHECK(ends == particles.bond_energies(50));
            for (std::uint32_t p = 0; p < particles.size(); ++p) {
                double sum = 0, size = 0;
                for (std::uint32_t slot = bonds.row[p]; slot < bonds.row[p + 1]; ++slot) {
                    sum += ends[0][slot], size += std::abs(ends[0][slot]);
                    const std::uint32_t back = bonds.opposite(p, slot);
                    REQUIRE_THAT(ends[1][slot], WithinRel(ends[0][back], 1e-9) || WithinAbs(0, 1e-12 * size));
                    if (bonds.is_broken(slot)) REQUIRE((ends[0][slot] == 0 && ends[1][slot] == 0));
                }
                REQUIRE_THAT(sum, WithinAbs(sample.law->energy(particles.block(p, 1)), 1e-12 * size));
            }
        }
    }
    CHECK(laws >= 10);
}
