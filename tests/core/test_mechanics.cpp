// Accelerations, friction laws and dense factors, compared with values derived independently.
#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include "cases.hpp"
#include "model/friction_law.hpp"
#include "numerics/dense.hpp"
#include "run/evaluate.hpp"

using namespace serpenoid;
using doctest::Approx;

TEST_CASE("friction opposes the motion; a ratchet has another one backwards") {
    const WheelLaw law{0.5, 0.1, 2.0, 0.7};
    CHECK(law.force(3.0) == Approx(-(0.5 * 3 + 0.1)));
    CHECK(law.force(-3.0) == Approx(2.0 * 3 + 0.7));
    CHECK(law.force(0.0) == 0);
    // At rest the force may have any value from thrust - bound to thrust + bound.
    CHECK(law.thrust() - law.bound() == Approx(-0.1));
    CHECK(law.thrust() + law.bound() == Approx(0.7));
}

// The expected values come from Lagrange's equations in SymPy, for three links.
TEST_CASE("accelerations of a chain with torques at its joints") {
    RunRequest request;
    request.robot = {3, 1.0, 0.06, 0.0012};
    request.ground = {{0.1, 0}, {10.0, 0}};
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

TEST_CASE("LU factors solve a dense complex system that needs exchanges of rows") {
    using Complex = std::complex<double>;
    constexpr int kSize = 7;
    DenseFactors<Complex> factors;
    std::vector<Complex>& columns = factors.begin(kSize);
    std::vector<Complex> b(kSize);
    for (int column = 0; column < kSize; ++column)
        for (int row = 0; row < kSize; ++row) {
            const double real = row == column ? 0.0 : std::sin(3.0 * row + 1.7 * column);
            const Complex value(real, std::cos(row - 2.0 * column));
            columns[column * kSize + row] = value;
            b[row] += value * Complex(column + 1, 2 * column);  // times the solution
        }
    REQUIRE(factors.factor());
    factors.solve(b.data());
    for (int row = 0; row < kSize; ++row) {
        CHECK(b[row].real() == Approx(row + 1).epsilon(1e-11));
        CHECK(b[row].imag() == Approx(2 * row).epsilon(1e-11));
    }
    factors.begin(2);
    CHECK_FALSE(factors.factor());
}
