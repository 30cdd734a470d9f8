// A robot whose joints are moved by servos, free on a floor that may slope: the lab's own motion.
//
// Unknowns u: the velocity of the centre of mass and the rate of every link. A step of h follows
// Gauss's principle: each body keeps the velocity it had, but for what forces ask,
//     minimise sum_links m/2 |v - v_k - h g|^2 + I/2 (w - w_k)^2 + sum_rotors J/2 (r - r_k)^2
//            + h (losses of gears - servos' power) and what lab_chain.hpp adds,
// v_k being that link's own velocity one step ago, in whatever shape the chain had then: no
// inertial force of the turning chain needs a formula. Gears are contacts, too. The error
// of a step is of the first order in h.
//
// With the quick solver (servos/) it shares the law of the servo and its supply, nothing else.
#pragma once

#include <vector>

#include "drive/servo.hpp"
#include "lab/lab_chain.hpp"

namespace serpenoid {

class DrivenChain : public LabChain {
  public:
    DrivenChain(const Robot& robot, std::vector<LabLink> links, const Servo& servo);

    // At rest, the centre of mass in the origin, link 1 at `theta`.
    void place(double theta, const std::vector<double>& joints);

    // Hold these setpoints for a frame, in `steps` equal steps; false where a step failed.
    bool frame(const std::vector<double>& setpoints, int steps);

    // x, y of the centre of mass, m, and the angle of every link, rad.
    void state(double* to) const;
    int joints() const { return n_ - 1; }
    double kinetic() const;
    double work() const { return work_; }  // of the servos' torques since it was placed, J

  private:
    bool step(double h);
    void shape(double h);
    void bodies(double h);
    void servos(double h);
    void gears(double h);
    void control();
    Contact& gear(int joint) { return contact_[2 * n_ + joint]; }
    double joint_angle(int i) const { return theta_[i + 1] - theta_[i]; }
    double joint_rate(int i) const { return u_[i + 3] - u_[i + 2]; }

    Servo servo_;
    std::vector<double> theta_;
    std::vector<double> goal_, duty_, torque_;  // of the joints; torque_ without the gear's
    double since_update_ = 0, work_ = 0;
};

}  // namespace serpenoid
