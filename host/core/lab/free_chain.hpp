// A chain whose joints are held or led, free on ground that may tilt and move: a belt, a floor.
//
// Three unknowns u = (Vx, Vy, w): the velocity of the centre of mass in the frame of the room, and
// the turning rate of link 1. With J the inertia about the centre of mass, K the angular momentum
// of the joints' motion alone, and v = (velocity of a link) - (velocity of the ground), a step of h
// seconds is implicit Euler with friction as the set-valued law it is (kinked_quadratic.hpp):
//
//     minimise nm/2 |V - V_k - h g|^2 + J/2 (w - w*)^2 + sum_links rolling/2 (v_t - v_t,k)^2
//              + h sum_links [ct v_t^2/2 + ft0 |v_t| + cn v_n^2/2 + fn0 |v_n|],
//     w* = (L_k - K)/J.
//
// `rolling` is J_wheels / r^2 of a link's wheels, whose spin goes with v_t. A link at rest may hold
// a larger force than it has when it slides. Every link has friction of its own. Nothing here knows
// a law of the whole robot; the error of a step is of the first order in h.
#pragma once

#include <array>
#include <vector>

#include "model/friction_law.hpp"
#include "model/params.hpp"
#include "numerics/kinked_quadratic.hpp"

namespace serpenoid {

// What the ground does to one link, and the wheels that it rolls on.
struct LabLink {
    Ground ground;
    double rolling;    // kg
    double breakaway;  // dry force at rest over that in motion, 1 or more
};

class FreeChain {
  public:
    FreeChain(const Robot& robot, std::vector<LabLink> links);

    // The centre of mass, m, the angle of link 1, rad, and their rates, in the room's frame. Wheels
    // turn as the ground then asks.
    void place(double x, double y, double theta, double vx, double vy, double w);
    void set_joints(const std::vector<double>& angle);        // at once, at rest
    void aim(const std::vector<double>& angle, double rate);  // joints go there so fast, rad/s
    void set_slope(double gx, double gy) { slope_ = {gx, gy}; }
    void set_ground_velocity(double x, double y) { ground_x_ = x, ground_y_ = y; }
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
    std::vector<double> places() const;

  private:
    struct Row {
        Vec3 g;
        double e;
        double at(const Vec3& u) const { return g[0] * u[0] + g[1] * u[1] + g[2] * u[2] + e; }
    };
    struct Part {
        double c, s;  // of the angle to link 1
        double rx, ry, dx, dy,
            w;  // from the centre of mass, its rate, and the angle's; link 1's axes
    };
    void shape();
    void rows(double theta);
    bool move_joints(double h);
    bool step(double h);
    void restart();

    Robot robot_;
    std::vector<LabLink> links_;
    std::vector<double> angle_, rate_, aim_;
    double most_rate_ = 0;
    bool guided_ = false;
    Slope slope_;
    double ground_x_ = 0, ground_y_ = 0;
    double x_ = 0, y_ = 0, theta_ = 0, heat_ = 0;
    Vec3 u_{};
    std::vector<double> spin_, skid_;  // v_t and v_n of each link at the end of the last step
    std::vector<Part> part_;
    double J_ = 0, K_ = 0;
    std::vector<Row> along_, across_;
    std::vector<Kink> kinks_;
    Convex3 convex_;
};

}  // namespace serpenoid
