// The motion over a short piece of a gait's cycle as a map that is made once and used every cycle.
// Viscous flat ground, joint angles imposed.
//
// In the body frame of body_shape.hpp the motion y = (Vx, Vy, L) obeys, by the phase tau,
//
//     dy/dtau = A(tau) y + b(tau) + q,   q = (L Vy, -L Vx, 0) / (omega J),
//
// whose A and b depend on the shape alone: friction is linear in y, and of the turning rate
// w = (L - omega K)/J that turns the body axes only the part L/J is not known beforehand. So
// Radau collocation (radau_collocation.hpp) on a piece makes its stages
//
//     Y = from y(start) + rest + swirl q(Y),
//
// three tables that hold for good. What is left to iterate is q, two products a stage; the last
// visit's is the first guess, for the motion is periodic before long.
#pragma once

#include <array>

#include "body/body_shape.hpp"
#include "model/gait.hpp"
#include "model/params.hpp"
#include "numerics/dense.hpp"
#include "numerics/radau_collocation.hpp"

namespace serpenoid {

class PhaseElement {
  public:
    static constexpr int kStages = 6;
    using Rule = RadauRule<kStages>;
    using Stages = std::array<double, kStages>;

    // Six things that move, each at all stages; places and angle are counted from the start, in
    // the body frame of the start.
    enum { Vx, Vy, L, angle, x, y, count };
    struct Solution {
        std::array<double, count> start{};  // the last three are 0
        std::array<Stages, count> stage{};
        std::array<double, count> defect{};  // h times that of radau_collocation.hpp, at the start
    };

    PhaseElement(const Robot& robot, const Ground& ground, const GaitTable& table, double omega,
                 double tau, double h, BodyShape& scratch);

    // Solve from to.start until q moves no stage by more than `slack` (m/s) any more.
    // Returns false when the iteration does not converge: the piece is too long.
    bool solve(double slack, Solution& to);

    double J() const { return J_; }  // kg m^2, at the end

  private:
    static constexpr int s = kStages, N = 3 * s;
    void tabulate(const std::array<Mat3, s>& A, const std::array<Vec3, s>& b);
    void swirl(const std::array<Stages, count>& Y, std::array<Stages, 2>& q) const;
    void follow(Solution& to) const;
    void defects(Solution& to) const;

    double h_, omega_, J_;
    std::array<std::array<double, N>, 3> from_;
    std::array<double, N> rest_;
    std::array<std::array<double, N>, 2 * s> swirl_;
    Stages spin_, recoil_;  // w = omega (spin L - recoil): 1/(omega J) and K/J
    double spin0_, recoil0_;
    Mat3 A0_, filter_;  // at the start; (1 - h bump A0)^-1, without which stiff defects mislead
    Vec3 b0_;
    std::array<Stages, 2> q_;
    bool visited_ = false;
};

}  // namespace serpenoid
