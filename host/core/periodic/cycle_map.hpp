// A cycle of a gait as a map: from the motion at phase 0 to what following it gives.
//
// State is p = (nm Vx, nm Vy, L) of body_shape.hpp. A gait that does not steer is its own mirror
// image half a cycle later, p(pi) = S p(0) with S = diag(1, -1, -1), as every joint angle has
// changed its sign: half a cycle is then enough. One that steers needs the whole cycle, S = 1.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "body/body_shape.hpp"
#include "numerics/dense.hpp"

namespace serpenoid {

struct CycleState {
    Vec3 p{};                        // nm Vx, nm Vy, L
    double theta = 0, x = 0, y = 0;  // heading, and place in axes that turn by `spin`
    double dissipated = 0;           // J
    // Derivatives by the first p: of p in the first three rows, then of the values named here.
    enum { kTheta = 3, kX, kY, kDissipated, kRows };
    std::array<Vec3, kRows> by_start{};
};

// Work of the joints over the cycle, J.
struct JointWork {
    std::vector<double> positive;  // integral of P_i^+ of each joint
    double error = 0;              // of their sum: by the samples and by ambiguous modes
    double net = 0;                // equals what friction takes, but for errors
};

// What following a cycle gives.
struct CycleEnd {
    CycleState state;
    JointWork work;  // where it was asked for
    // Two sliding wheels stopped at one moment. Which of them is first in a motion beside this one
    // depends on the direction of the disturbance: there is no one derivative.
    bool simultaneous_events = false;
};

// How to follow: local errors stay below `tolerance` of the scales.
struct Following {
    double tolerance;
    bool work = false;  // sum up the joints' work
    double spin = 0;    // turning of the axes in which x, y are counted, rad a rad
};

// Signs of the components half a cycle later, or a whole one.
inline Vec3 mirror_signs(bool mirrored) { return mirrored ? Vec3{1, -1, -1} : Vec3{1, 1, 1}; }

// Displacement in the axes of the start, and change of heading.
struct Path {
    double x, y, turn;

    // The path of a whole period from that of its first half: the second half is the mirror image,
    // seen from the heading then.
    Path twice_mirrored() const {
        const double c = std::cos(turn), s = std::sin(turn);
        return {x + c * x + s * y, y + s * x - c * y, 0};
    }
    double length() const { return std::hypot(x, y); }
    double direction() const { return std::atan2(y, x); }
};

class CycleMap {
  public:
    CycleMap(const Robot& robot, const Gait& gait) : CycleMap(robot, gait, gait.offset == 0) {}
    // `mirrored`: half a cycle is enough.
    CycleMap(const Robot& robot, const Gait& gait, bool mirrored);
    virtual ~CycleMap() = default;

    // Follow from p at phase 0 over the span. Nothing where the steps run out or get too short.
    virtual std::optional<CycleEnd> follow(const Vec3& p, const Following& how) = 0;

    // Whether no wheel has modes. Then the ends of pieces are far more accurate than `tolerance`.
    virtual bool smooth() const { return false; }

    bool mirrored() const { return mirrored_; }
    double span() const { return mirrored_ ? std::numbers::pi : 2 * std::numbers::pi; }  // of phase
    double time() const { return span() / gait_.omega; }  // of the span, s
    double nm() const { return nm_; }
    const Gait& gait() const { return gait_; }
    const Vec3& scale() const { return scale_; }  // of p
    // The state, over the scales, of such velocities in the body frame at phase 0.
    Vec3 scaled(const Vec3& u) const {
        return {nm_ * u[0] / scale_[0], nm_ * u[1] / scale_[1], momentum(u[2]) / scale_[2]};
    }
    // At phase 0: the turning rate w of a given L, and L of a chain that does not turn.
    double rate(double L) const { return (L - gait_.omega * shape_.K) / shape_.J; }
    double momentum(double w) const { return shape_.J * w + gait_.omega * shape_.K; }
    double momentum_at_rest() const { return gait_.omega * shape_.K; }

  protected:
    Robot robot_;
    Gait gait_;
    GaitTable table_;
    double nm_;
    Vec3 scale_;

  private:
    bool mirrored_;
    BodyShape shape_;  // at phase 0
};

inline CycleMap::CycleMap(const Robot& robot, const Gait& gait, bool mirrored)
    : robot_(robot),
      gait_(gait),
      table_(robot.n, gait),
      nm_(robot.n * robot.m),
      mirrored_(mirrored) {
    const double v = gait.omega * robot.l * std::max(gait.alpha, 1e-9), arm = robot.n * robot.l;
    scale_ = {nm_ * v, nm_ * v, robot.n * (robot.I + robot.m * arm * arm / 12) * v / arm};
    shape_.set(robot_, table_, 0, 1, false);
}

}  // namespace serpenoid
