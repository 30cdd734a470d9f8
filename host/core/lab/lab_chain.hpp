// The lab's robot: a chain whose joints are led, or driven by servos, free on ground that may tilt
// and move: a belt, a floor.
//
// Unknowns u: the velocity of the centre of mass in the frame of the room, and the rate of every
// link, or of link 1 alone where the joints are led. The speed of a wheel, and the rate of a link,
// is row u + offset; offsets hold the motion of led joints and of the ground. A step of h follows
// Gauss's principle: each body keeps the velocity it had, but for what forces ask,
//     minimise sum_links m/2 |v - v_k - h g|^2 + I/2 (w - w_k)^2 + sum_rotors J/2 (r - r_k)^2
//            + h (losses of wheels and gears - servos' power),
// v_k being that link's own velocity one step ago, in whatever shape the chain had then: no
// inertial force of the turning chain needs a formula. Everything dry gives an impulse within
// bounds, which sweeps over all contacts find (projected Gauss-Seidel): each in turn takes the
// impulse that leaves it no speed, or the bound. The error of a step is of the first order in h.
//
// The law of friction stands here a second time, on purpose: the product's own law is another
// file's, so that an error in either makes lab and product disagree. Only the data types of robot,
// ground and slope, Cholesky's factor, and the law of the servo and its supply are shared.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "drive/servo.hpp"
#include "model/params.hpp"

namespace serpenoid {

// What the ground does to one link, and the wheels that it rolls on.
struct LabLink {
    Ground ground;
    double rolling;    // J_wheels / r^2, kg: the wheels' spin goes with the speed along the link
    double breakaway;  // dry force at rest over that in motion, 1 or more
};

class LabChain {
  public:
    // Joints are led where there is no servo.
    LabChain(const Robot& robot, std::vector<LabLink> links, std::optional<Servo> servo);

    // The centre of mass, m, the angle of link 1, rad, and their rates, in the room's frame. Wheels
    // turn as the ground then asks.
    void place(double x, double y, double theta, double vx, double vy, double w);
    void set_joints(const std::vector<double>& angle);  // at once, at rest
    // Led joints go there at this rate, rad/s.
    void aim(const std::vector<double>& angle, double rate);
    // Rails at both sides, without friction: neither across (y) nor turning. Led joints alone.
    void guide(bool guided) { guided_ = guided; }
    void set_slope(double gx, double gy) { slope_ = {gx, gy}; }
    void set_ground_velocity(double x, double y) {
        ground_x_ = x;
        ground_y_ = y;
    }

    // Let time pass in steps of at most h, s. False where a step has no solution (not a number).
    bool advance(double duration, double h);
    // The same, with these setpoints of the servos; led joints come to them at the end, evenly.
    bool follow(const std::vector<double>& angle, double duration, double h);

    int joints() const { return n_ - 1; }
    // x, y, theta, vx, vy, w, and the heat of the wheels' friction since it was placed, J.
    std::array<double, 7> state() const { return {x_, y_, theta_[0], u_[0], u_[1], u_[2], heat_}; }
    const std::vector<double>& angles() const { return theta_; }  // of the links, rad
    double kinetic() const;                                       // of links, wheels, rotors, J
    double work() const { return work_; }  // of the servos' torques since it was placed, J
    // Of each link: x, y of its centre, angle; in the room's frame.
    std::vector<double> places();

  private:
    struct Row {
        std::vector<double> row;
        double offset = 0;
        double speed = 0;  // at the end of the last step
    };
    struct Contact : Row {
        std::vector<double> response;           // of u to an impulse of 1
        double mass = 0;                        // against its impulse; 0: it moves nothing
        double viscous = 0;                     // N s/m times the step
        double impulse = 0, low = 0, high = 0;  // N s or N m s, and its bounds in this step
    };

    bool step(double h);
    void turn_joints(double h);
    void control(double h);
    void shape(double h);
    const std::vector<double>& turning(const std::vector<double>& rate);
    void bodies(double h);
    void drive(double h);
    void resist(double h);
    bool sweep();
    void settle();
    void restart();
    void point(const std::vector<double>& angle);
    void add_square(const Row& row, double weight, double target);
    Contact& gear(int joint) { return contact_[2 * n_ + joint]; }
    double joint_angle(int i) const { return theta_[i + 1] - theta_[i]; }

    Robot robot_;
    std::vector<LabLink> links_;
    std::optional<Servo> servo_;
    int n_;
    int size_;  // of u
    Slope slope_;
    bool guided_ = false;
    double ground_x_ = 0, ground_y_ = 0;  // m/s
    double x_ = 0, y_ = 0;                // of the centre of mass, m
    double heat_ = 0, work_ = 0;          // J
    double since_update_ = 0;             // s, of the servos' loops
    std::vector<double> theta_;           // of the links, rad
    std::vector<double> vx_, vy_;         // of the links at the end of the last step, in the room
    std::vector<double> goal_, max_rate_, duty_, torque_;  // of the joints; torque without the gear
    std::vector<double> led_rate_;                         // of the links to link 1, rad/s
    std::vector<std::vector<double>> turns_;  // of the links, by each rate among the unknowns
    std::vector<double> u_, mass_, right_, c_, s_, speeds_;
    std::vector<Row> link_;         // the links' rates
    std::vector<Contact> contact_;  // wheels along and across each link, then gears
};

}  // namespace serpenoid
