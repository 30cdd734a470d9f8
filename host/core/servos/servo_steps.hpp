// A servo-driven robot in time steps that never revision for events, for many cycles at little
// cost.
//
// Velocities u = (V of the centre of mass, rate of every link), ground frame. A step of h takes the
// links half a step on, and there solves the implicit midpoint rule
//     M (u1 - u0) = h Q(u0 + u1 / 2) + sum_k lambda_k g_k
// for masses M (chain and rotors), forces Q that are linear in u for the step (Coriolis, servos,
// viscous friction), and impulses lambda of everything dry: wheels along and across, and gears.
// g_k u is the speed at which contact k slides. Its impulse is that of its friction, against the
// speed at the end of the step, or any smaller one that leaves no speed: an active-set method finds
// which. Where a contact reverses in a step its impulse is the mean of both ways, by the instant
// at which a straight line passes 0: the step is of order 2 there, too.
#pragma once

#include <functional>
#include <utility>
#include <vector>

#include "drive/servo.hpp"
#include "model/friction_law.hpp"
#include "model/gait.hpp"
#include "model/params.hpp"

namespace serpenoid {

class ServoSteps {
  public:
    ServoSteps(const Robot& robot, const Ground& ground, const Gait& gait, const Servo& servo,
               double longest);

    // All joints where the gait has them at phase 0, the body at (Vx, Vy, rate) of the frame of
    // link 1.
    void start(double vx, double vy, double rate);
    // Let the next cycle's first frame begin `shift` of a frame after it.
    void shift_frames(double shift);
    // Follow the gait for a cycle from phase 0; the frames of the cycle before go on.
    void cycle();
    // Take steps of at most `longest`, each cut into so many equal ones.
    void take_steps(double longest, int split) {
        longest_ = longest;
        split_ = split;
    }
    // Call `after_step(share)` after every step: the share of a cycle of the longest steps that the
    // work of this one is. It may throw to end the work.
    void report_steps(std::function<void(double)> after_step) {
        after_step_ = std::move(after_step);
    }

    // The body's state, as start() takes it, but for the momentum L in place of the rate.
    void body(double* v) const;
    void set_body(const double* v);

    // Of the last cycle.
    struct Path {
        double speed = 0;      // m/s, along the mean circle (periodic_state.hpp)
        double turn = 0;       // rad
        double power = 0;      // W, mean of the joints' net power, gears included
        double amplitude = 0;  // first harmonic of the joints over that of the gait, mean
        double lag = 0;        // rad, of the first harmonic
        double ripple = 0;     // rms of the joints' rates beside their first harmonic, rad/s
        std::vector<double> gain, shift;  // of each joint: amplitude over the gait's, phase, rad
    };
    const Path& path() const { return path_; }

  private:
    struct Contact {
        std::vector<double> row, response;  // g, and L^-1 g for masses L L^T
        double forward = 0, backward = 0;   // N or N m, against either way
        int mode = 0;                       // 1 or -1: the way it slides; 0 rests
        double speed = 0;                   // at the start of the step
        double impulse = 0;
        bool has_response = false;  // in this step
        bool dry() const { return forward > 0 || backward > 0; }
    };
    void step(double h);
    void masses(double h);
    void rotor_term(int i, double f);
    double joint(const std::vector<double>& u, int i) const { return u[i + 3] - u[i + 2]; }
    void control(const std::vector<double>& u);
    void drive(double h);
    void wheels(double h);
    void slide(double h);
    void apply_impulses();
    void hold();
    bool revise(double h, bool all);
    bool turn_round(double h);
    double bound(const Contact& c, int mode, double h) const;
    void enter();
    void tally(double h);
    void finish(double turn);
    double momentum(const double* rate) const;

    Robot robot_;
    Ground ground_;
    Gait gait_;
    GaitTable table_;
    Servo servo_;
    double longest_;
    int split_ = 1;
    std::function<void(double)> after_step_{};
    int n_;
    int size_;
    std::vector<double> lever_, inertia_;  // B and m l^2 B^T B, n x n
    std::vector<double> theta_, c_, s_;
    std::vector<double> u_, last_u_,
        extrapolated_u_;  // velocities: now, a step ago, half a step ahead
    std::vector<double> mass_, right_, free_, gram_, pull_;
    std::vector<double> goal_, duty_, stall_torque_, torque_per_rate_;  // of the joints
    std::vector<Contact> contact_;
    std::vector<Contact*> resting_;
    double t_ = 0, frame_ = 0, update_ = 0;  // the next ones, from the cycle's start
    double tick_, period_;

    struct Sample {
        double t, h, vx, vy;
    };
    std::vector<Sample> samples_;
    std::vector<double> wave_;  // of each joint's rate: sums over cos and sin of the gait's phase
    double squares_ = 0, work_ = 0;
    Path path_;
};

}  // namespace serpenoid
