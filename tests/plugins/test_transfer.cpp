// Scatter and gather of pic, flip and apic on one tile; REFERENCES.md E9 and A8.
#include <random>

#include "perimpm/math/bspline.hpp"
#include "support/catch.hpp"
#include "support/model.hpp"
#include "support/tile.hpp"

using namespace perimpm;
using Eigen::Matrix3d;

namespace {

using Kernel = ModelPtr<TransferKernel, double>;

template <class Real = double>
ModelPtr<TransferKernel, Real> kernel(const std::string& name, int order, const std::string& more = "") {
    return make<TransferKernel, Real>(name, "order = " + std::to_string(order) + "\n" + more);
}

template <class Real>
constexpr double kEpsilon = std::numeric_limits<Real>::epsilon();

double coordinate(std::mt19937& random, double low, double high) {
    return std::uniform_real_distribution(low, high)(random);
}
Vec3 vector(std::mt19937& random, double low, double high) {
    return {coordinate(random, low, high), coordinate(random, low, high), coordinate(random, low, high)};
}

constexpr double kSpacing = 0.4;

/// Particles at random places whose stencils of every order lie inside the tile, with random masses and velocities.
template <class Real = double>
Tile<Real> random_tile(std::size_t size) {
    std::mt19937 random(7);
    Tile<Real> tile(size, kSpacing);
    for (std::size_t p = 0; p < size; ++p)
        tile.place(p, kSpacing * vector(random, 1.01, 5.99), vector(random, -1, 1), coordinate(random, 0.5, 2.0));
    return tile;
}

/// Slope of the degree-n B-spline at distance t from its node [1/dx].
double slope(int order, double t) {
    const double a = std::abs(t), sign = t < 0 ? -1 : 1;
    if (order == 1) return a < 1 ? -sign : 0;
    if (order == 2) return a < 0.5 ? -2 * t : a < 1.5 ? sign * (a - 1.5) : 0;
    return a < 1 ? sign * (1.5 * a * a - 2 * a) : a < 2 ? -0.5 * sign * (2 - a) * (2 - a) : 0;
}

/// Nodal force over sigma A of an endless line of particles with spacing s (dx = 1) under uniform stress: their volumes
/// are s A each, so it is s sum_k N'(first + k s); nought if the sum were the integral.
double line_force(int order, double s, double first) {
    double sum = 0;
    for (int k = -20; k <= 20; ++k) sum += slope(order, first + k * s);
    return s * sum;
}

/// The same from what `scatter` adds to the nodes with velocity 0 and dt = 1; cubic splines reach two cells: only the
/// tile's two middle planes see the whole line. The line starts `first` from plane 3.
double scattered_force(const TransferKernel<double>& kernel, double s, double first) {
    std::vector<double> line;
    for (int k = -20; k <= 20; ++k)
        if (const double x = 3 + first + k * s; x >= 1 && x < 6) line.push_back(x);
    Tile<double> tile(line.size(), 1.0);
    for (std::size_t p = 0; p < line.size(); ++p) {
        tile.place(p, {line[p], 3.3, 3.6}, Vec3::Zero(), 1.0, s);
        tile.set_tau(p, 0, 1.0);
    }
    tile.scatter(kernel, 1.0, true);
    return tile.plane_momentum(3)[0];
}

}  // namespace

TEST_CASE("transfer: nodal forces of a drifting line reproduce the cell-crossing table", "[transfer]") {
    const double spacings[] = {0.25, 0.5, 1.0, 0.30, 0.45, 0.60, 0.75, 0.90, 1.2, 1.5};
    struct Row {
        int order;
        std::string printed[10];
    };
    // Printed are the largest values over sampled positions: up to 1 % below the supremum, apart from their rounding.
    const Row table[] = {{1, {"0", "0", "0", "0.30", "0.45", "0.60", "0.75", "0.90", "1.20", "1.50"}},
                         {2, {"0", "0", "0", "0.030", "0.045", "0.120", "0.187", "0.089", "0.238", "0.748"}},
                         {3, {"0", "0", "0", "0.0020", "0.0030", "0.016", "0.031", "0.006", "0.032", "0.25"}}};
    for (const Row& row : table)
        for (const char* name : {"pic", "flip", "apic"}) {
            const Kernel k = kernel(name, row.order);
            for (std::size_t i = 0; i < std::size(spacings); ++i) {
                CAPTURE(name, row.order, spacings[i]);
                double worst = 0;
                constexpr int kPhases = 1800;  // meets every kink of the piecewise polynomials
                for (int phase = 0; phase < kPhases; ++phase) {
                    const double first = spacings[i] * (phase + 1e-9) / kPhases;
                    const double force = scattered_force(*k, spacings[i], first);
                    CHECK_THAT(force, WithinAbs(-line_force(row.order, spacings[i], first), 1e-12));
                    worst = std::max(worst, std::abs(force));
                }
                const double printed = std::stod(row.printed[i]);
                const double half_digit =
                    printed == 0 ? 1e-8 : 0.5 * std::pow(10.0, 2.0 - static_cast<double>(row.printed[i].size()));
                CHECK(worst >= printed - half_digit);
                CHECK(0.99 * worst <= printed + half_digit);
            }
        }
}

TEMPLATE_TEST_CASE("transfer: mass and momentum arrive on the grid", "[transfer]", float, double) {
    const std::size_t size = 100;
    for (const char* name : {"pic", "flip", "apic"})
        for (const int order : {1, 2, 3}) {
            CAPTURE(name, order);
            Tile<TestType> tile = random_tile<TestType>(size);
            tile.scatter(*kernel<TestType>(name, order), 0.01, true);
            double mass = 0, scale = 0, grid_mass = 0;
            Vec3 momentum = Vec3::Zero(), grid_momentum = Vec3::Zero(), spin = Vec3::Zero(), grid_spin = Vec3::Zero();
            for (std::size_t p = 0; p < size; ++p) {
                mass += tile.mass(p), scale += tile.mass(p) * tile.v(p).norm();
                momentum += tile.mass(p) * tile.v(p);
                spin += tile.x(p).cross(tile.mass(p) * tile.v(p));
            }
            for (std::size_t n = 0; n < Tile<TestType>::kNodes; ++n) {
                grid_mass += tile.node_mass(n);
                grid_momentum += tile.node_momentum(n);
                grid_spin += tile.node_position(n).cross(tile.node_momentum(n));
            }
            CHECK_THAT(grid_mass, WithinRel(mass, 100 * kEpsilon<TestType>));
            CHECK((grid_momentum - momentum).norm() <= 100 * kEpsilon<TestType> * scale);
            CHECK((grid_spin - spin).norm() <= 100 * kEpsilon<TestType> * scale);  // sum_I w_I x_I = x_p
        }
}

TEST_CASE("transfer: forces on the grid have no resultant, gradient or mls", "[transfer]") {
    std::mt19937 random(8);
    for (const char* name : {"pic", "flip", "apic"})
        for (const char* divergence : {"gradient", "mls"}) {
            CAPTURE(name, divergence);
            Tile<double> tile(20, kSpacing);
            for (std::size_t p = 0; p < 20; ++p) {
                tile.place(p, kSpacing * vector(random, 1.01, 5.99), Vec3::Zero());
                for (std::size_t c = 0; c < 6; ++c) tile.set_tau(p, c, coordinate(random, -1, 1));
            }
            tile.scatter(*kernel(name, 2, std::string("stress_divergence = \"") + divergence + '"'), 1.0, true);
            Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
            double scale = 0;
            for (std::size_t n = 0; n < Tile<double>::kNodes; ++n) {
                force += tile.node_momentum(n), scale += tile.node_momentum(n).norm();
                torque += tile.node_position(n).cross(tile.node_momentum(n));
            }
            CHECK(force.norm() <= 1e-13 * scale);
            CHECK(torque.norm() <= 1e-12 * scale);  // tau is symmetric
        }
}

TEST_CASE("transfer: nodal force is minus V tau grad w", "[transfer]") {
    // One particle at a cell's middle with dx = 1: linear weights 1/2, derivatives -1 and 1 along x.
    Tile<double> tile(1, 1.0);
    tile.place(0, {2.5, 2.5, 2.5}, Vec3::Zero(), 1.0, 3.0);
    tile.set_tau(0, 0, 2.0);
    tile.set_tau(0, 1, 5.0);
    for (const char* name : {"pic", "flip", "apic"}) {
        tile.scatter(*kernel(name, 1), 0.5, true);
        const std::size_t left = (2 * 8 + 2) * 8 + 2, right = (3 * 8 + 2) * 8 + 2;
        // -dt V (tau_xx dw_x + tau_xy dw_y, tau_xy dw_x, 0), dw_x = -+1/4, dw_y = -1/4
        CHECK((tile.node_momentum(left) - 0.5 * 3.0 / 4 * Vec3(2.0 + 5.0, 5.0, 0)).norm() <= 1e-14);
        CHECK((tile.node_momentum(right) - 0.5 * 3.0 / 4 * Vec3(-2.0 + 5.0, -5.0, 0)).norm() <= 1e-14);
    }
}

/// What apic's C is times: 1, for linear splines the second moments f (1 - f) of the place in its cell.
Matrix3d moments(int order, const Vec3& x) {
    Vec3 D = Vec3::Ones();
    for (int c = 0; order == 1 && c < 3; ++c) {
        const double f = x[c] / kSpacing - std::floor(x[c] / kSpacing);
        D[c] = f * (1 - f);
    }
    return D.asDiagonal();
}

TEMPLATE_TEST_CASE("transfer: gather moves with the grid's velocity and updates F by its gradient", "[transfer]", float,
                   double) {
    Matrix3d L;
    L << 0.3, -0.2, 0.1, 0.5, 0.7, -0.4, -0.6, 0.2, 0.1;
    const Vec3 v0(1.0, -2.0, 0.5);
    const double dt = 0.01, eps = kEpsilon<TestType>;
    for (const char* name : {"pic", "flip", "apic"})
        for (const char* divergence : {"gradient", "mls"})
            for (const int order : {1, 2, 3}) {
                if (order == 1 && std::string(divergence) == "mls") continue;
                CAPTURE(name, order, divergence);
                const auto k = kernel<TestType>(name, order, std::string("stress_divergence = \"") + divergence + '"');
                Tile<TestType> tile = random_tile<TestType>(30);
                tile.scatter(*k, dt, true);
                tile.update();
                std::vector<Vec3> before;
                for (std::size_t p = 0; p < 30; ++p) before.push_back(tile.x(p));
                tile.set_velocities([&](const Vec3& x) -> Vec3 { return v0 + L * x; });
                tile.gather(*k, dt, true);
                for (std::size_t p = 0; p < 30; ++p) {
                    CHECK((tile.x(p) - (before[p] + dt * (v0 + L * before[p]))).norm() <= 50 * eps);
                    CHECK((tile.F(p) - (Matrix3d::Identity() + dt * L)).norm() <= 50 * eps);
                    if (std::string(name) != "flip") CHECK((tile.v(p) - (v0 + L * before[p])).norm() <= 500 * eps);
                    if (std::string(name) == "apic")
                        CHECK((tile.C(p) - L * moments(order, before[p])).norm() <= 5000 * eps);
                }
            }
}

namespace {

/// What a particle at x should read from a field of nodal velocities: nodes one by one, all in double precision.
struct Reading {
    Vec3 v = Vec3::Zero();
    Matrix3d gradient = Matrix3d::Zero(), moment = Matrix3d::Zero();  // sum v (grad w)^T, sum w v (x_I - x)^T
};

template <int Order>
Reading reading(const Vec3& x, const std::function<Vec3(const Vec3&)>& field) {
    const BSpline<double, Order> s[3] = {BSpline<double, Order>(x[0] / kSpacing),
                                         BSpline<double, Order>(x[1] / kSpacing),
                                         BSpline<double, Order>(x[2] / kSpacing)};
    Reading r;
    for (int i = 0; i <= Order; ++i)
        for (int j = 0; j <= Order; ++j)
            for (int k = 0; k <= Order; ++k) {
                const Vec3 node = kSpacing * Vec3(s[0].base + i, s[1].base + j, s[2].base + k), v = field(node);
                const double w = s[0].w[i] * s[1].w[j] * s[2].w[k];
                const Vec3 slopes(s[0].dw[i] * s[1].w[j] * s[2].w[k], s[0].w[i] * s[1].dw[j] * s[2].w[k],
                                  s[0].w[i] * s[1].w[j] * s[2].dw[k]);
                r.v += w * v;
                r.gradient += v * slopes.transpose() / kSpacing;
                r.moment += w * v * (node - x).transpose() / (kSpacing * kSpacing);
            }
    return r;
}

Reading reading(int order, const Vec3& x, const std::function<Vec3(const Vec3&)>& field) {
    return order == 1 ? reading<1>(x, field) : order == 2 ? reading<2>(x, field) : reading<3>(x, field);
}

}  // namespace

TEMPLATE_TEST_CASE("transfer: particles read every node of their stencils, however many lie in a cell", "[transfer]",
                   float, double) {
    const double dt = 0.01, eps = kEpsilon<TestType>;
    const auto now = [](const Vec3& x) -> Vec3 {
        return {std::sin(7 * x[0] + 3 * x[1]), std::cos(5 * x[1] - 4 * x[2]), std::sin(6 * x[2] + 2 * x[0])};
    };
    const auto before = [](const Vec3& x) -> Vec3 {
        return {std::cos(4 * x[2] + x[1]), std::sin(3 * x[0] - 2 * x[1]), std::cos(8 * x[1] + x[0])};
    };
    std::mt19937 random(5);
    std::vector<Vec3> places;
    const int counts[] = {1, 2, 9, 1, 3, 1, 1, 8, 4, 2, 17, 6, 1, 10, 5, 7, 2};
    for (int cell = 0; cell < static_cast<int>(std::size(counts)); ++cell)
        for (int p = 0; p < counts[cell]; ++p)
            places.push_back(kSpacing * (Vec3(1 + cell % 5, 1 + cell / 5, 1 + cell % 4) + vector(random, 0.51, 0.99)));
    for (const char* name : {"pic", "flip", "apic"})
        for (const char* divergence : {"gradient", "mls"})
            for (const int order : {1, 2, 3}) {
                const bool mls = std::string(divergence) == "mls", flip = std::string(name) == "flip";
                if (order == 1 && mls) continue;
                CAPTURE(name, divergence, order);
                const auto k = kernel<TestType>(
                    name, order,
                    std::string("stress_divergence = \"") + divergence + '"' + (flip ? "\nblend = 0.75" : ""));
                Tile<TestType> tile(places.size(), kSpacing);
                for (std::size_t p = 0; p < places.size(); ++p) tile.place(p, places[p], Vec3(1, 2, 3), 1.0);
                tile.set_velocities(now, before);
                std::vector<Vec3> x;
                for (std::size_t p = 0; p < places.size(); ++p) x.push_back(tile.x(p));
                tile.gather(*k, dt, true);
                const double second = order == 2 ? 0.25 : 1.0 / 3, carried = order == 1 ? 1 : second;
                for (std::size_t p = 0; p < places.size(); ++p) {
                    const Reading r = reading(order, x[p], now);
                    const Vec3 grid_v = r.v, own = Vec3(1, 2, 3) + r.v - reading(order, x[p], before).v;
                    CHECK((tile.x(p) - (x[p] + dt * grid_v)).norm() <= 20 * eps);
                    CHECK((tile.v(p) - (flip ? Vec3(0.75 * own + 0.25 * grid_v) : grid_v)).norm() <= 100 * eps);
                    const Matrix3d gradient = mls ? Matrix3d(r.moment / second) : r.gradient;
                    CHECK((tile.F(p) - (Matrix3d::Identity() + dt * gradient)).norm() <= 50 * eps);
                    if (std::string(name) == "apic") CHECK((tile.C(p) - r.moment / carried).norm() <= 1000 * eps);
                }
            }
}

TEMPLATE_TEST_CASE("apic: an affine velocity field survives scatter and gather", "[transfer]", float, double) {
    Matrix3d L;
    L << 0.3, -0.2, 0.1, 0.5, 0.7, -0.4, -0.6, 0.2, 0.1;
    const Vec3 v0(1.0, -2.0, 0.5);
    const double eps = kEpsilon<TestType>;
    for (const int order : {1, 2, 3}) {
        CAPTURE(order);
        const auto k = kernel<TestType>("apic", order);
        Tile<TestType> tile = random_tile<TestType>(50);
        for (std::size_t p = 0; p < 50; ++p) {
            tile.place(p, tile.x(p), v0 + L * tile.x(p), tile.mass(p));
            tile.set_C(p, L * moments(order, tile.x(p)));
        }
        tile.scatter(*k, 0.0, true);
        tile.update();
        tile.gather(*k, 0.0, true);
        for (std::size_t p = 0; p < 50; ++p) {
            CHECK((tile.v(p) - (v0 + L * tile.x(p))).norm() <= 5000 * eps);
            CHECK((tile.C(p) - L * moments(order, tile.x(p))).norm() <= 50000 * eps);
        }
    }
}

TEST_CASE("flip: blend 1 adds the grid's change, blend 0 is pic", "[transfer]") {
    const double dt = 0.01;
    for (const int order : {1, 2, 3}) {
        CAPTURE(order);
        const Kernel full = kernel("flip", order, "blend = 1.0"), none = kernel("flip", order, "blend = 0.0"),
                     pic = kernel("pic", order);
        Tile<double> tile = random_tile(40), as_pic = random_tile(40), start = random_tile(40), other = random_tile(40);
        tile.scatter(*full, dt, true);
        tile.update();
        tile.gather(*full, dt, true);
        other.scatter(*none, dt, true), other.update(), other.gather(*none, dt, true);
        as_pic.scatter(*pic, dt, true), as_pic.update(), as_pic.gather(*pic, dt, true);
        for (std::size_t p = 0; p < 40; ++p) {
            CHECK((tile.v(p) - start.v(p)).norm() <= 1e-14);  // no force, no change
            CHECK((other.v(p) - as_pic.v(p)).norm() <= 1e-14);
            CHECK((tile.x(p) - as_pic.x(p)).norm() <= 1e-14);
        }
    }
}

TEST_CASE("transfer: flip keeps a mode that the grid cannot see, pic and apic erase it", "[transfer]") {
    // Linear splines, two particles a quarter cell beside each middle, velocities alternating: every node sums to zero.
    const std::size_t size = 10;
    const auto alternating = [&] {
        Tile<double> tile(size, 1.0);
        for (std::size_t p = 0; p < size; ++p)
            tile.place(p, {1.25 + 0.5 * static_cast<double>(p), 2.5, 2.5}, Vec3(p % 2 ? -1.0 : 1.0, 0, 0));
        return tile;
    };
    for (const char* name : {"flip", "pic", "apic"}) {
        CAPTURE(name);
        const Kernel k = kernel(name, 1, std::string(name) == "flip" ? "blend = 1.0" : "");
        Tile<double> tile = alternating();
        tile.scatter(*k, 0.01, true);
        for (std::size_t i = 2; i < 6; ++i) CHECK(tile.plane_momentum(i).norm() <= 1e-15);
        tile.update(), tile.gather(*k, 0.01, true);
        for (std::size_t p = 2; p < 8; ++p)
            CHECK((tile.v(p) - Vec3(std::string(name) == "flip" ? (p % 2 ? -1.0 : 1.0) : 0.0, 0, 0)).norm() <= 1e-15);
    }
    const Kernel flip = kernel("flip", 1, "blend = 1.0");
    Tile<double> tile = alternating();
    for (int step = 0; step < 100; ++step) tile.scatter(*flip, 0.0, true), tile.update(), tile.gather(*flip, 0.0, true);
    for (std::size_t p = 0; p < size; ++p) CHECK(tile.v(p) == Vec3(p % 2 ? -1.0 : 1.0, 0, 0));
}

TEST_CASE("transfer: mls needs a spline with a second moment", "[transfer]") {
    for (const char* name : {"pic", "flip", "apic"})
        CHECK_THROWS_AS(kernel(name, 1, "stress_divergence = \"mls\""), InvalidParameter);
}

TEST_CASE("particle: kick and drift", "[transfer]") {
    const auto model = make<TransferKernel, double>("particle");
    CHECK_FALSE(model->needs().grid);
    const auto* integrator = dynamic_cast<const ParticleIntegrator<double>*>(model.get());
    REQUIRE(integrator);
    double x[3] = {1, 2, 3}, v[3] = {0, 1, 0}, force[3] = {4, 0, -2}, mass = 2;
    const double gravity[3] = {0, -10, 0};
    TransferBlock<double> b;
    b.size = 1, b.dt = 0.5;
    b.x = {x, 1}, b.v = {v, 1}, b.force = {force, 1}, b.mass = &mass;
    integrator->kick(b, gravity);  // dt/2 (f/m + g) = 1/4 (2, -10, -1)
    CHECK((v[0] == 0.5 && v[1] == -1.5 && v[2] == -0.25));
    integrator->drift(b);
    CHECK((x[0] == 1.25 && x[1] == 1.25 && x[2] == 2.875));
}
