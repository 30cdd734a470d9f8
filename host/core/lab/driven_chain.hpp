// A robot whose joints are moved by servos, free on a floor that may slope: the lab's own motion.
//
// Unknowns u: the velocity of the tail link's centre, the rate of every link and, where gears have
// play, of every rotor (at its joint). A step of h follows Gauss's principle: each body keeps the
// velocity it had, but for what forces ask,
//     minimise sum_links m/2 |v - v_k - h g|^2 + I/2 (w - w_k)^2 + rolling/2 (v_t - v_t,k)^2
//            + sum_rotors J/2 (r - r_k)^2 + h (viscous losses - servos' power),
// v_k and v_t,k being that link's own velocity one step ago, in whatever shape the chain had then:
// no inertial force of the turning chain needs a formula. Dry friction, gears and teeth give
// impulses within bounds, found by sweeps over all of them (projected Gauss-Seidel). The error of a
// step is of the first order in h.
//
// Nothing here is shared with the quick solver (servos/) but the law of the servo itself.
#pragma once

#include <vector>

#include "drive/servo.hpp"
#include "lab/free_chain.hpp"

namespace serpenoid {

class DrivenChain {
  public:
    DrivenChain(const Robot& robot, std::vector<LabLink> links, const Servo& servo);

    // At rest, the centre of mass in the origin, link 1 at `theta`.
    void place(double theta, const std::vector<double>& joints);
    void set_slope(double gx, double gy) { slope_ = {gx, gy}; }

    // Hold these setpoints for a frame, in `steps` equal steps; false where a step failed.
    bool frame(const std::vector<double>& setpoints, int steps);

    // x, y of the centre of mass, m, and the angle of every link, rad.
    void state(double* to) const;
    int joints() const { return n_ - 1; }
    double kinetic() const;
    // Since it was placed, J: of the servos' torques, and what all friction and impacts took.
    double work() const { return work_; }

  private:
    struct Contact {
        std::vector<double> row;
        double impulse = 0, least = 0, most = 0;  // N s or N m s, and its bounds in this step
        double low = 0, high = 0;                 // speeds between which no impulse acts (teeth)
        double before = 0;                        // speed at the end of the last step
        bool tooth = false;
    };
    bool step(double h);
    void shape(double h);
    void bodies(double h);
    void servos(double h);
    void contacts(double h);
    bool sweep();
    void control();
    int rotor(int joint) const { return play_ ? 2 + n_ + joint : -1; }
    double joint_angle(int i) const { return theta_[i + 1] - theta_[i]; }
    double joint_rate(int i) const { return u_[i + 3] - u_[i + 2]; }
    double rotor_rate(int i) const { return play_ ? u_[rotor(i)] : joint_rate(i); }
    void add(const double* row, double weight, double target);

    Robot robot_;
    std::vector<LabLink> links_;
    Servo servo_;
    int n_, size_;
    bool play_;
    Slope slope_;
    double x_ = 0, y_ = 0;  // of link 1's centre
    std::vector<double> theta_, gap_, u_;
    std::vector<double> along_x_, along_y_;     // rows of every link's velocity, n x size
    std::vector<double> vx_, vy_;               // of every link, one step ago
    std::vector<double> goal_, duty_, torque_;  // of the joints; torque_ without the gear's
    std::vector<double> mass_, right_, reach_, gram_, speed_;
    std::vector<Contact> contact_;
    double since_update_ = 0, work_ = 0;
};

}  // namespace serpenoid
