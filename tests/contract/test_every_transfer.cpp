// What holds for every installed transfer, found through the registry.
#include <cmath>
#include <random>

#include "support/every_model.hpp"
#include "support/tile.hpp"

using namespace perimpm;

namespace {

template <class Real = double>
ModelPtr<TransferKernel, Real> transfer(const std::string& name) {
    return make<TransferKernel, Real>(name, smallest_table(Family::transfer, name));
}

/// Moving particles under stress, stencils inside the tile.
template <class Real>
Tile<Real> random_tile(std::size_t size) {
    std::mt19937 random(13);
    std::uniform_real_distribution<double> place(1.01, 5.99), number(-1, 1);
    Tile<Real> tile(size, 1.0);
    for (std::size_t p = 0; p < size; ++p) {
        tile.place(p, {place(random), place(random), place(random)}, {number(random), number(random), number(random)},
                   1.5 + number(random));
        for (std::size_t c = 0; c < 6; ++c) tile.set_tau(p, c, number(random));
    }
    return tile;
}

}  // namespace

TEST_CASE("every transfer: declares what it needs", "[contract]") {
    for (const std::string& name : names_of(Family::transfer)) {
        CAPTURE(name);
        const auto kernel = transfer(name);
        const TransferNeeds needs = kernel->needs();
        CHECK(needs.grid == (needs.order > 0));
        CHECK(needs.grid == (needs.courant > 0));
        CHECK(needs.grid != (dynamic_cast<ParticleIntegrator<double>*>(kernel.get()) != nullptr));
        if (!needs.grid) CHECK_FALSE((needs.affine || needs.increment));
    }
}

TEMPLATE_TEST_CASE("every transfer: one step conserves mass and momentum", "[contract]", float, double) {
    const std::size_t size = 60;
    const double rounding = 200 * static_cast<double>(std::numeric_limits<TestType>::epsilon());
    for (const std::string& name : names_of(Family::transfer)) {
        CAPTURE(name);
        const auto kernel = transfer<TestType>(name);
        if (!kernel->needs().grid) continue;
        for (const bool local : {true, false}) {
            Tile<TestType> tile = random_tile<TestType>(size);
            double mass = 0, node_mass = 0, scale = 0;
            Vec3 before = Vec3::Zero(), after = Vec3::Zero();
            for (std::size_t p = 0; p < size; ++p) {
                mass += tile.mass(p), before += tile.mass(p) * tile.v(p), scale += tile.mass(p) * tile.v(p).norm();
            }
            tile.scatter(*kernel, 0.1, local);
            for (std::size_t n = 0; n < Tile<TestType>::kNodes; ++n) node_mass += tile.node_mass(n);
            tile.update();
            tile.gather(*kernel, 0.1, local);
            for (std::size_t p = 0; p < size; ++p) after += tile.mass(p) * tile.v(p);
            CHECK_THAT(node_mass, WithinRel(mass, rounding));
            CHECK((after - before).norm() <= rounding * scale);
        }
    }
}

TEST_CASE("every transfer: gather only reads the velocities that it declares", "[contract]") {
    for (const std::string& name : names_of(Family::transfer)) {
        CAPTURE(name);
        const auto kernel = transfer(name);
        if (!kernel->needs().grid) continue;
        Tile<double> known = random_tile<double>(60), unknown = random_tile<double>(60);
        for (Tile<double>* tile : {&known, &unknown}) tile->scatter(*kernel, 0.1, true), tile->update();
        for (std::size_t p = 0; p < 60; ++p) {
            unknown.set_C(p, Eigen::Matrix3d::Constant(std::nan("")));
            if (!kernel->needs().own_velocity)
                unknown.place(p, unknown.x(p), Vec3::Constant(std::nan("")), unknown.mass(p));
        }
        for (Tile<double>* tile : {&known, &unknown}) tile->gather(*kernel, 0.1, true);
        for (std::size_t p = 0; p < 60; ++p) {
            CHECK(known.v(p) == unknown.v(p));
            if (kernel->needs().affine) CHECK(known.C(p) == unknown.C(p));
        }
    }
}

TEST_CASE("every transfer: a body in uniform motion keeps its velocity and F", "[contract]") {
    const std::size_t size = 60;
    const Vec3 v(0.3, -0.2, 0.1);
    for (const std::string& name : names_of(Family::transfer)) {
        CAPTURE(name);
        const auto kernel = transfer(name);
        if (!kernel->needs().grid) continue;
        Tile<double> tile = random_tile<double>(size), start = random_tile<double>(size);
        for (std::size_t p = 0; p < size; ++p) {
            tile.place(p, tile.x(p), v, tile.mass(p));
            for (std::size_t c = 0; c < 6; ++c) tile.set_tau(p, c, 0.0);
        }
        tile.scatter(*kernel, 0.1, true), tile.update(), tile.gather(*kernel, 0.1, true);
        for (std::size_t p = 0; p < size; ++p) {
            CHECK((tile.v(p) - v).norm() <= 1e-14);
            CHECK((tile.x(p) - start.x(p) - 0.1 * v).norm() <= 1e-14);
            CHECK((tile.F(p) - Eigen::Matrix3d::Identity()).norm() <= 1e-13);
        }
    }
}

TEST_CASE("every transfer: declared keys have unit and text, misspelt ones a suggestion", "[contract]") {
    for (const std::string& name : names_of(Family::transfer)) {
        CAPTURE(name);
        check_declaration(Family::transfer, name);
    }
}
