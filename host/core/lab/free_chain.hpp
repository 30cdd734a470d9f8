// A chain whose joints are held or led, free on ground that may tilt and move: a belt, a floor.
//
// Three unknowns: the velocity of the centre of mass V and the turning rate of link 1, w. With J
// the inertia about the centre of mass and L the angular momentum, of which the joints' motion
// alone makes K, a step of h seconds is implicit Euler:
//     minimise nm/2 |V - V_k - h g|^2 + J/2 (w - (L_k - K)/J)^2 and what lab_chain.hpp adds.
// Every link has friction of its own. Nothing here knows a law of the whole robot; the error of a
// step is of the first order in h.
#pragma once

#include <array>
#include <vector>

#include "lab/lab_chain.hpp"

namespace serpenoid {

class FreeChain : public LabChain {
  public:
    FreeChain(const Robot& robot, std::vector<LabLink> links);

    // The centre of mass, m, the angle of link 1, rad, and their rates, in the room's frame. Wheels
    // turn as the ground then asks.
    void place(double x, double y, double theta, double vx, double vy, double w);
    void set_joints(const std::vector<double>& angle);        // at once, at rest
    void aim(const std::vector<double>& angle, double rate);  // joints go there so fast, rad/s
    // Rails at both sides, without friction: neither across (y) nor turning.
    void guide(bool guided) { guided_ = guided; }

    // Let time pass in steps of at most h, s. False where a step has no solution (not a number).
    bool advance(double duration, double h);
    // Lead the joints along the line to these angles within the time, whatever rate that is.
    bool lead(const std::vector<double>& angle, double duration, double h);

    // x, y, theta, vx, vy, w, and the heat of friction since it was placed, J.
    std::array<double, 7> state() const { return {x_, y_, theta_, u_[0], u_[1], u_[2], heat_}; }
    const std::vector<double>& joints() const { return angle_; }
    double kinetic() const;
    // Of each link: x, y of its centre, angle; in the room's frame.
    std::vector<double> places();

  private:
    void shape(double theta);
    bool step(double h);
    void restart();

    std::vector<double> angle_, rate_, aim_;
    std::vector<double> links_angle_, links_rate_, ones_;  // the rate by the joints alone
    double most_rate_ = 0;
    bool guided_ = false;
    double theta_ = 0, J_ = 0, K_ = 0;
};

}  // namespace serpenoid
