// kBox: 512 particles of one bond law in four chunks of 128; kRow: four of them in a row, bonds between neighbours.
#include <array>
#include <atomic>
#include <mutex>
#include <set>

#include "support/catch.hpp"
#include "support/world.hpp"

using namespace perimpm;

namespace {

constexpr double kSpacing = 0.05;  // of kBox's particles [m]
const std::string kShort = R"(material.rubber.constitutive={ type = "pd_bond", youngs_modulus = 1e5, horizon = 1.1 })";
const std::string kAtHalf = R"(material.rubber.fracture={ type = "critical_stretch", critical_stretch = 0.5 })";

/// Cuts nothing and remembers the chunks that it was shown.
class Watcher final : public FractureCriterion<double> {
public:
    explicit Watcher(double harmless) : harmless_{harmless} {}
    double harmless_stretch() const noexcept override { return harmless_; }
    void screen(const Block<double>& b, CandidateList&) const override {
        const std::lock_guard lock(mutex_);
        seen_.insert(b.first / kChunk);
    }
    std::set<std::size_t> take() const { return std::exchange(seen_, {}); }

private:
    double harmless_;
    mutable std::mutex mutex_;
    mutable std::set<std::size_t> seen_;
};

/// Counts the particles that were prepared, and those that were evaluated before all of them were.
class Counter final : public ConstitutiveLaw<double> {
public:
    explicit Counter(std::size_t particles) : particles_{particles} {}
    LawNeeds needs() const noexcept override { return {.bonds = true, .prepare = true, .horizon = kSpacing}; }
    void prepare(Block<double>& b) const override { prepared += b.size; }
    void evaluate(Block<double>& b, double) const override {
        if (prepared != particles_) early += b.size;
        evaluated += b.size;
    }
    double max_wave_speed(const Block<double>&) const override { return 0; }
    double energy(const Block<double>&) const override { return 0; }

    mutable std::atomic<std::size_t> prepared{0}, evaluated{0}, early{0};

private:
    std::size_t particles_;
};

/// Replaces a material's model by one of the test's own, which lives as long as the test keeps it.
template <class Model, template <class> class Interface>
void lend(Model& model, ModelPtr<Interface, double>& to) {
    to = ModelPtr<Interface, double>(&model, [](Interface<double>*) {});
}

/// |Y|/|X| - 1 of every live bond, from positions as they are; the largest of each chunk, at least 0.
std::vector<double> largest_stretches(const World<double>& w) {
    const Material<double>& m = w.materials[0];
    std::vector<double> largest(m.chunks(), 0.0);
    for (std::size_t p = 0; p < m.size; ++p)
        for (std::uint32_t slot = m.bonds.row[p]; slot < m.bonds.row[p + 1]; ++slot) {
            if (m.bonds.broken[slot / 64] >> slot % 64 & 1) continue;
            const std::size_t q = m.bonds.neighbour[slot];
            Vec3 X;
            for (int c = 0; c < 3; ++c) X[c] = m.reference[4 * q + c] - m.reference[4 * p + c];
            const double stretch = (at(w.x, q) - at(w.x, p)).norm() / X.norm() - 1;
            largest[p / kChunk] = std::max(largest[p / kChunk], stretch);
        }
    return largest;
}

void expand(World<double>& w, double factor) {
    for (std::size_t p = 0; p < w.count; ++p)
        for (int c = 0; c < 3; ++c) w.x[c][p] = factor * w.materials[0].reference[4 * p + c];
}

/// Index of the particle at place n of the row.
std::size_t member(const World<double>& w, int n) {
    for (std::size_t p = 0; p < w.count; ++p)
        if (std::abs(w.materials[0].reference[4 * p] - kSpacing * (n + 0.5)) < 1e-9) return p;
    return w.count;
}

}  // namespace

TEST_CASE("bond_forces: laws see the present positions", "[step]") {
    const auto w = box_world({kBonds});
    Material<double>& m = w->materials[0];
    for (std::size_t p = 0; p < w->count; ++p)
        for (int c = 0; c < 3; ++c) w->x[c][p] += static_cast<double>(p) + 0.1 * c;
    compute_bond_forces(*w);
    for (std::size_t p = 0; p < w->count; ++p)
        for (int c = 0; c < 3; ++c) CHECK(m.position[4 * p + c] == w->x[c][p]);
}

TEST_CASE("bond_forces: every family is prepared before any force is evaluated", "[step]") {
    const auto w = box_world({kBonds});
    Material<double>& m = w->materials[0];
    REQUIRE(m.chunks() == 4);
    Counter law(w->count);
    lend(law, m.law);
    m.needs.prepare = true;
    compute_bond_forces(*w);
    CHECK(law.prepared == 512);
    CHECK(law.evaluated == 512);
    CHECK(law.early == 0);
    m.needs.prepare = false;  // the law says that there is nothing to prepare
    compute_bond_forces(*w);
    CHECK(law.prepared == 512);
    CHECK(law.evaluated == 1024);
}

TEST_CASE("bond_forces: a uniform stretch pulls the ends of a row by the spring's force", "[step]") {
    const auto w = box_world({kShort, kNoGrid, kRow, kAtHalf});
    expand(*w, 1.2);
    compute_bond_forces(*w);
    const Material<double>& m = w->materials[0];
    const std::size_t first = member(*w, 0), last = member(*w, 3);
    // (1) of pd_bond: k (|Y| - |X|), k declared per bond; pulls inside cancel for equal bonds, whose ends differ here
    const auto pull = [&](std::size_t p) { return m.constants.declared[0][m.constants.shape[p]] * 0.2 * kSpacing; };
    CHECK_THAT(m.force[0][first], WithinRel(pull(first), 1e-12));
    CHECK_THAT(m.force[0][last], WithinRel(-pull(last), 1e-12));
    double sum = 0;
    for (std::size_t p = 0; p < 4; ++p) sum += m.force[0][p];
    CHECK(std::abs(sum) <= 1e-15 * pull(first));
}

TEST_CASE("bond_forces: the largest stretch of every chunk is kept for the criterion", "[step]") {
    for (const std::string& law : {kBonds, kElastic}) {
        const auto w = box_world({law, kNoGrid, kNeverBreaks});
        Material<double>& m = w->materials[0];
        REQUIRE(m.stretch == std::vector<double>(4, std::numeric_limits<double>::infinity()));
        expand(*w, 1.3);
        compute_bond_forces(*w);
        for (const double stretch : m.stretch) CHECK_THAT(stretch, WithinRel(0.3, 1e-12));
        expand(*w, 0.8);
        compute_bond_forces(*w);
        CHECK(m.stretch == std::vector<double>(4, 0.0));
        expand(*w, 1.0);
        w->x[1][200] += 0.4 * kSpacing;
        compute_bond_forces(*w);
        const std::vector<double> expected = largest_stretches(*w);
        CHECK(expected[1] > 0.3);  // the particle's own chunk
        for (std::size_t c = 0; c < 4; ++c) CHECK_THAT(m.stretch[c], WithinAbs(expected[c], 1e-14));
    }
}

TEST_CASE("bond_forces: a criterion sees only chunks with stretches above the harmless one", "[step]") {
    const auto w = box_world({kElastic, kNoGrid, kNeverBreaks});
    Material<double>& m = w->materials[0];
    const Watcher watcher(0.2);
    lend(const_cast<Watcher&>(watcher), m.criterion);
    const std::set<std::size_t> every{0, 1, 2, 3};
    const auto asked = [&] {
        compute_bond_forces(*w);
        return watcher.take();
    };
    expand(*w, 1.19);
    CHECK(asked().empty());
    expand(*w, 1.21);
    CHECK(asked() == every);
    expand(*w, 1.0);
    w->x[1][200] += 0.4 * kSpacing;
    std::set<std::size_t> expected;
    for (std::size_t c = 0; c < 4; ++c)
        if (largest_stretches(*w)[c] > 0.2) expected.insert(c);
    REQUIRE(expected.size() < 4);
    CHECK(asked() == expected);
}

TEST_CASE("bond_forces: where stretches are unknown or none is harmless, every chunk is screened", "[step]") {
    const std::set<std::size_t> every{0, 1, 2, 3};
    for (const bool reports : {false, true}) {
        const auto w = box_world({kElastic, kNoGrid, kNeverBreaks});
        w->materials[0].needs.reports_stretch = reports;
        const Watcher watcher(reports ? -std::numeric_limits<double>::infinity() : 0.2);
        lend(const_cast<Watcher&>(watcher), w->materials[0].criterion);
        compute_bond_forces(*w);
        CHECK(watcher.take() == every);
    }
}

TEST_CASE("bond_forces: what breaks does not depend on whether the law reports stretches", "[step]") {
    for (const std::string& law : {kBonds, kElastic}) {
        std::vector<std::unique_ptr<World<double>>> worlds;
        for (const bool reports : {true, false}) {
            auto& w = *worlds.emplace_back(box_world({law, kNoGrid, kAtHalf}));
            w.materials[0].needs.reports_stretch = reports;
            for (std::size_t p = 0; p < w.count; ++p)  // faster outside: the block bursts from its corners inwards
                for (int c = 0; c < 3; ++c) w.v[c][p] = 3e3 * std::pow(w.x[c][p] - 0.2, 3);
            for (w.steps = 0; w.steps < 20; ++w.steps) w.dt = 1e-3, integrate_particles(w);
        }
        const Material<double>&a = worlds[0]->materials[0], &b = worlds[1]->materials[0];
        std::uint32_t broken = 0;
        for (std::size_t p = 0; p < a.size; ++p) {
            broken += a.bonds.damage[p];
            CHECK(a.bonds.damage[p] == b.bonds.damage[p]);
            for (int c = 0; c < 3; ++c) {
                CHECK(worlds[0]->x[c][p] == worlds[1]->x[c][p]);
                CHECK(a.force[c][p] == b.force[c][p]);
            }
        }
        CHECK(broken > 0);
        CHECK(broken < a.bonds.size());
    }
}

TEST_CASE("bond_forces: a bond cut in a step has no force in it", "[step]") {
    const auto pulled = [](const std::string& fracture) {
        auto w = box_world({kShort, kNoGrid, kRow, fracture});
        w->x[0][member(*w, 2)] += 0.2 * kSpacing;
        w->x[0][member(*w, 3)] += 1.0 * kSpacing;  // stretches along the row: 0, 0.2, 0.8
        compute_bond_forces(*w);
        std::array<double, 4> force{};
        for (int n = 0; n < 4; ++n) force[static_cast<std::size_t>(n)] = w->materials[0].force[0][member(*w, n)];
        return force;
    };
    const std::array<double, 4> whole = pulled(kNeverBreaks), cut = pulled(kAtHalf);
    CHECK(whole[3] < 0);
    CHECK(cut[3] == 0);
    CHECK(cut[1] > 0);
    CHECK_THAT(cut[2], WithinRel(-cut[1], 1e-12));  // only the bond between them is left
    CHECK(cut[0] == 0);
}
