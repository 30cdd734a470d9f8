// From the tail link in the ground's frame, where runs are recorded, to the body frame and back.
#pragma once

#include <cmath>

#include "body/body_shape.hpp"

namespace serpenoid {

// The chain as a whole: place of its centre of mass and heading of link 1 in the ground's frame,
// velocity of the centre of mass in the body frame of body_shape.hpp, angular momentum about it.
struct BodyState {
    double x, y, theta, Vx, Vy, L;
};

// What the change of frame needs of a shape.
struct TailFrame {
    double rx, ry, rx1, ry1, J, K;  // rho and rho' of the tail, and the moments of the shape

    explicit TailFrame(const BodyShape& s)
        : rx(s.link[0].rx),
          ry(s.link[0].ry),
          rx1(s.link[0].rx1),
          ry1(s.link[0].ry1),
          J(s.J),
          K(s.K) {}

    // y: x, y, theta of link 1, then their rates.
    BodyState body(const double y[6], double omega) const {
        const double c = std::cos(y[2]), s = std::sin(y[2]);
        return {y[0] - (c * rx - s * ry),
                y[1] - (s * rx + c * ry),
                y[2],
                c * y[3] + s * y[4] + y[5] * ry - omega * rx1,
                -s * y[3] + c * y[4] - y[5] * rx - omega * ry1,
                J * y[5] + omega * K};
    }
    void tail(const BodyState& b, double omega, double y[6]) const {
        const double c = std::cos(b.theta), s = std::sin(b.theta), turn = (b.L - omega * K) / J;
        const double ux = b.Vx - turn * ry + omega * rx1, uy = b.Vy + turn * rx + omega * ry1;
        y[0] = b.x + c * rx - s * ry, y[1] = b.y + s * rx + c * ry, y[2] = b.theta;
        y[3] = c * ux - s * uy, y[4] = s * ux + c * uy, y[5] = turn;
    }
};

}  // namespace serpenoid
