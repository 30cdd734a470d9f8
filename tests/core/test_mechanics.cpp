// Right-hand sides and laws of friction, against figures that were derived apart from this code.
#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include "cases.hpp"
#include "model/friction_law.hpp"
#include "numerics/dense.hpp"
#include "run/evaluate.hpp"

using namespace serpenoid;
using doctest::Approx;

TEST_CASE("friction opposes the motion, and may differ backwards") {
    const WheelLaw law(0.5, 2.0, 0.1, 0.7);
    CHECK(law.force(3.0) == Approx(-(0.5 * 3 + 0.1)));
    CHECK(law.force(-3.0) == Approx(2.0 * 3 + 0.7));
    CHECK(law.force(0.0) == 0);
    // at rest any force between both ends: thrust +- bound
    CHECK(law.thrust - law.bound == Approx(-0.1));
    CHECK(law.thrust + law.bound == Approx(0.7));
}

// Three links whose joints have torques, by Lagrange's equations in SymPy.
TEST_CASE("accelerations of a chain with torques at its joints") {
    RunRequest request;
    request.robot = {3, 1.0, 0.06, 0.0012};
    request.ground = {0.1, 10.0, 0, 0};
    request.drive = Drive::torque;
    Chain chain(3);
    Joints joints(3);
    chain.x[0] = 0.1;
    chain.y[0] = -0.2;
    chain.theta = {0.3, -0.4, 0.7};
    chain.vx[0] = 0.05;
    chain.vy[0] = -0.03;
    chain.omega = {1.1, -0.7, 0.4};
    chain.directions();
    chain.follow(request.robot.l);
    joints.T = {0.02, -0.01};
    const double unused[2] = {};
    evaluate(request, unused, chain, joints);
    CHECK(chain.ax[0] == Approx(0.29644152322).epsilon(1e-11));
    CHECK(chain.ay[0] == Approx(0.322294357236).epsilon(1e-11));
    CHECK(chain.alpha[0] == Approx(5.963369138345).epsilon(1e-11));
    CHECK(chain.alpha[1] == Approx(-7.68832830881).epsilon(1e-11));
    CHECK(chain.alpha[2] == Approx(2.550904313997).epsilon(1e-11));
}

TEST_CASE("factors of a dense matrix solve it, real and complex, with rows to exchange") {
    constexpr int kSize = 7;
    DenseFactors real;
    ComplexFactors complex;
    std::vector<double>& columns = real.begin(kSize);
    complex.begin(kSize);
    std::vector<double> b(kSize), b_re(kSize), b_im(kSize);
    for (int column = 0; column < kSize; ++column)
        for (int row = 0; row < kSize; ++row) {
            const int i = column * kSize + row;
            const double value = row == column ? 0.0 : std::sin(3.0 * row + 1.7 * column);
            const double turned = std::cos(row - 2.0 * column);
            columns[i] = value;
            complex.re[i] = value;
            complex.im[i] = turned;
            // the solution is 1, 2, ...; of the complex system that and its double, times i
            b[row] += value * (column + 1);
            b_re[row] += (value - 2 * turned) * (column + 1);
            b_im[row] += (turned + 2 * value) * (column + 1);
        }
    REQUIRE(real.factor());
    REQUIRE(complex.factor());
    real.solve(b);
    complex.solve(b_re, b_im);
    for (int row = 0; row < kSize; ++row) {
        CHECK(b[row] == Approx(row + 1).epsilon(1e-11));
        CHECK(b_re[row] == Approx(row + 1).epsilon(1e-11));
        CHECK(b_im[row] == Approx(2 * (row + 1)).epsilon(1e-11));
    }
    real.begin(2);
    CHECK_FALSE(real.factor());
}
