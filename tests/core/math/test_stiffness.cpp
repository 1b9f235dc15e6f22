#include "perimpm/math/stiffness.hpp"
#include "support/catch.hpp"

using namespace perimpm;
using Eigen::Vector3d;

namespace {

/// In the span of the first `dimension` axes.
Stiffness isotropic(double lambda, double mu, int dimension) {
    Stiffness C = Stiffness::Zero();
    C.topLeftCorner(dimension, dimension).setConstant(lambda);
    C.topLeftCorner(dimension, dimension).diagonal().array() += 2 * mu;
    if (dimension == 3) C(3, 3) = C(4, 4) = mu;
    if (dimension > 1) C(5, 5) = mu;
    return C;
}

Stiffness cubic(double C11, double C12, double C44) {
    Stiffness C = isotropic(C12, (C11 - C12) / 2, 3);
    C(3, 3) = C(4, 4) = C(5, 5) = C44;
    return C;
}

}  // namespace

TEST_CASE("stiffness: isotropic tensors are their own average, in space, in plane stress and along a line", "[math]") {
    const double E = 2e5, nu = 0.3, mu = E / (2 * (1 + nu));
    const double lambda[] = {0, E * nu / (1 - nu * nu), E * nu / ((1 + nu) * (1 - 2 * nu))};
    for (const int d : {2, 3}) {
        const Stiffness C = isotropic(lambda[d - 1], mu, d);
        const IsotropicAverage average = isotropic_average(C, d);
        CHECK_THAT(average.youngs_modulus(), WithinRel(E, 1e-12));
        CHECK_THAT(average.poisson_ratio(), WithinRel(nu, 1e-12));
        const Eigen::Matrix3Xd basis = resisting_directions(C);
        REQUIRE(basis.cols() == d);
        const DirectionalModulus modulus(C);
        for (const Vector3d& n : directions_in(basis)) CHECK_THAT(modulus(n), WithinRel(E, 1e-12));
    }
    const Stiffness bar = isotropic(0, E / 2, 1);
    CHECK_THAT(isotropic_average(bar, 1).youngs_modulus(), WithinRel(E, 1e-12));
    REQUIRE(resisting_directions(bar).cols() == 1);
    CHECK_THAT(DirectionalModulus(bar)(Vector3d::UnitX()), WithinRel(E, 1e-12));
}

TEST_CASE("stiffness: a cubic solid along its edges and its diagonals", "[math]") {
    const double C11 = 5, C12 = 2, C44 = 0.7, K = (C11 + 2 * C12) / 3, shear = (C11 - C12) / 2;
    const DirectionalModulus modulus(cubic(C11, C12, C44));
    CHECK_THAT(modulus(Vector3d::UnitY()), WithinRel(9 * K * shear / (3 * K + shear), 1e-12));
    CHECK_THAT(modulus(Vector3d(1, -1, 1).normalized()), WithinRel(9 * K * C44 / (3 * K + C44), 1e-12));
    // 1/E of a face diagonal lies midway between those of (100) and of (111) by its share in x^2 y^2 + ...: 1/4 of 1/3
    const double edge = 1 / modulus(Vector3d::UnitX()), diagonal = 1 / modulus(Vector3d(1, 1, 1).normalized());
    CHECK_THAT(1 / modulus(Vector3d(1, 0, 1).normalized()), WithinRel(edge + 0.75 * (diagonal - edge), 1e-12));
}

TEST_CASE("stiffness: mechanisms give way and negative tensors have no modulus", "[math]") {
    const DirectionalModulus springs_along_axes(cubic(1, 0, 0));
    CHECK_THAT(springs_along_axes(Vector3d::UnitZ()), WithinRel(1.0, 1e-12));
    CHECK(springs_along_axes(Vector3d(1, 1, 0).normalized()) == 0);
    CHECK(std::isinf(DirectionalModulus(cubic(1, 0, -0.1))(Vector3d::UnitX())));
}
