// Motion of the chain on dry ground with imposed joint angles and set-valued friction.
//
// One implicit Euler step from tau_k over h seconds is a convex problem in u = (V, w), the body
// frame of body_shape.hpp (kinked_quadratic.hpp solves it exactly, sticking wheels included):
//
//     minimise nm/2 |V - V*|^2 + J/2 (w - w*)^2
//              + h sum_links [ct v_t^2/2 + ft0 |v_t| + cn v_n^2/2 + fn0 |v_n|],
//     V* = V_k turned by -h w_k (body axes turn with link 1),  w* = (L_k - omega K)/J.
//
// On a slope V* has h g, too, in the axes of the heading theta_k + h w_k; weight turns nothing. A
// ratchet has the ct of the way that its wheel goes, the mean of both ways as ft0, and half their
// difference as a constant thrust along its link.
//
// Its solution says of every wheel whether it slides forwards, backwards or sticks: the mode. While
// the mode lasts the motion is smooth, and Euler steps of n_j = 1, 2, 3, ... parts with the mode
// held are linear systems that extrapolate to high order (Aitken-Neville). A sliding speed that
// reaches zero, or a sticking force that reaches its bound, ends the mode: that instant is found by
// secants, and one very short convex step finds the next mode. There is no smoothing width.
#pragma once

#include <array>
#include <functional>
#include <limits>
#include <vector>

#include "body/body_shape.hpp"
#include "model/friction_law.hpp"
#include "numerics/kinked_quadratic.hpp"

namespace serpenoid {

// The state of a step: three of motion, then integrals, then the sticking forces over their bounds,
// which are extrapolated, too.
struct DryState {
    enum { Vx, Vy, L, theta, x, y, dissipated, stick, size = stick + 3 };
    std::array<double, size> v{};
};

class DryMotion {
  public:
    // The scale of speeds is that of the gait; least_bend, rad, is for chains that hardly bend.
    DryMotion(const Robot& robot, const Ground& ground, const Gait& gait, const Slope& slope = {},
              double least_bend = 1e-9);

    // Advance from phase tau to tau_end with each step's error below `tolerance` times the speed
    // scale omega l alpha. Returns false when the steps run out.
    bool advance(DryState& state, double tau, double tau_end, double tolerance);

    // The same, and add the time integral of sum P_i^+ to `positive`, J: joint powers at Gauss
    // points within every smooth step, and after every short one times its length.
    bool advance_with_power(DryState& state, double tau, double tau_end, double tolerance,
                            double& positive);
    double net_work() const { return net_work_; }  // of the joints then, J

    // Count x and y in axes that turn by `spin` rad a rad of phase.
    void turn_axes(double spin) { spin_ = spin; }

    // Find the mode of a state that advance did not leave, and put in its sticking forces.
    bool find_mode(DryState& state, double tau);

    // Friction along and across every link at a state in the present mode, N, by pairs.
    void friction(const DryState& state, double tau, std::vector<double>& force);

    double momentum(double w, double tau);  // L of a given turning rate
    double rate(double L, double tau);      // and back
    long systems() const { return systems_; }
    void let_through(std::function<void()> ask) { let_through_ = std::move(ask); }
    void limit(long systems) { most_systems_ = systems; }  // of all calls together

    // Take a step's rows up to the expected order, even where fewer do. Long smooth pieces at tight
    // tolerances need that, or the order never rises. Periodic states have short pieces.
    void climb() { climbs_ = true; }

  private:
    static constexpr int kMaxOrder = 8;
    struct Step {
        DryState to;
        std::vector<double> margin;  // of every kink at the end: below -2 its mode has ended
        std::vector<double> early;   // and at the fraction 1/rows of the step
        std::array<double, kMaxOrder + 1> error{};
        int rows = 0;
    };
    bool euler(const DryState& from, double tau, double h_phase, bool fixed, DryState& to,
               double& w);
    void assemble(double h, const double* before);
    void wheel_forces(const DryState& state, std::vector<double>& force);
    void joint_power(const DryState& state, double tau, double* power, int stride);
    bool add_positive(const DryState& from, double tau, double H, double tolerance);
    void add_positive_of_event(const DryState& to, double tau, double length);
    double dissipation(const Vec3& u) const;
    double grip(int kink) const { return across_.has_modes() && kink % 2 ? 1 : grip_; }
    double error_norm(const DryState& a, const DryState& b) const;
    bool extrapolate(const DryState& from, double tau, double H, double tolerance, Step& step);
    void margins(const DryState& s, double tau, std::vector<double>& margin);
    double event_before(const std::vector<double>& start, const Step& step) const;
    void control(const Step& step, double H, bool accepted);
    bool event_step(DryState& state, double& tau, double tau_end);

    Robot robot_;
    Ground ground_;
    Slope slope_;
    double omega_, speed_scale_, power_scale_, arm_, spin_ = 0;
    WheelLaw along_, across_;
    double grip_;  // of wheels along a link

    double* positive_ = nullptr;
    double net_work_ = 0;
    GaitTable table_;
    BodyShape shape_;
    Convex3 convex_;
    Mat3 H_{};
    Vec3 b_{};
    std::vector<Kink> kinks_;
    std::vector<double> wheel_force_;
    std::function<void()> let_through_;  // called at every step
    long systems_ = 0, most_systems_ = std::numeric_limits<long>::max();
    double step_ = 0.1, event_step_length_ = 0, shortest_event_step_ = 0, longest_event_step_ = 0,
           speed_eps_ = 0, stick_eps_ = 0;
    int order_ = 4;
    bool climbs_ = false;
};

}  // namespace serpenoid
