// The robot of the lab: a chain with imposed joint angles or servos, on ground that may be tilted
// and may move (a belt, a floor).
//
// Unknowns u: the velocity of the centre of mass in the frame of the room, and the rate of every
// link, or only of link 1 if the joint angles are imposed. The speed of a wheel and the rate of a
// link are row.u + offset; the offsets are the motion of imposed joints and of the ground. A step
// of length h follows Gauss's principle of least constraint:
//     minimise sum_links m/2 |v - v_k - h g|^2 + I/2 (w - w_k)^2 + sum_rotors J/2 (r - r_k)^2
//            + h (losses of wheels and gears - servos' power),
// where v_k, w_k and r_k are velocities of links and rotors at the end of the previous step, in its
// shape; so inertial forces need no formulas. Dry friction gives impulses within bounds, found by
// projected Gauss-Seidel: each contact in turn takes the impulse that stops it, or the bound. The
// method has order 1.
//
// The friction law is written here again on purpose, not taken from model/friction_law.hpp: an
// error in either makes lab and simulator disagree. They share only the data types of robot, ground
// and slope, the Cholesky factor, and the law of the servo and its supply.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "drive/servo.hpp"
#include "model/params.hpp"

namespace serpenoid {

// The friction and the wheels of one link.
struct LabLink {
    Ground ground;
    double rolling;    // J_wheels / r^2, kg: inertia of the wheels' spin, as a mass along the link
    double breakaway;  // dry friction at rest over that in motion, 1 or more
};

class LabChain {
  public:
    // The joint angles are imposed if there is no servo.
    LabChain(const Robot& robot, std::vector<LabLink> links, std::optional<Servo> servo);

    // Set the centre of mass, m, the angle of link 1, rad, and their rates, in the frame of the
    // room. The wheels roll on the ground.
    void place(double x, double y, double theta, double vx, double vy, double w);
    void set_joints(const std::vector<double>& angle);  // set angles, rad, with all joints at rest
    // Move imposed joints towards these angles, rad, at this rate, rad/s.
    void aim(const std::vector<double>& angle, double rate);
    // Put the robot between rails without friction: no motion across (y), no rotation. It must have
    // imposed joint angles.
    void guide(bool guided) { guided_ = guided; }
    void set_slope(double gx, double gy) { slope_ = {gx, gy}; }
    void set_ground_velocity(double x, double y) {
        ground_x_ = x;
        ground_y_ = y;
    }

    // Simulate for a duration, s, in steps of at most h, s. False if the state is no longer finite.
    bool advance(double duration, double h);
    // The same with these setpoints, rad: servos aim at them at once, imposed joints reach them at
    // the end, at constant rates.
    bool follow(const std::vector<double>& angle, double duration, double h);

    int joints() const { return n_ - 1; }
    // x, y, theta of link 1, vx, vy, w, and the heat of the wheels' friction since `place`, J.
    std::array<double, 7> state() const { return {x_, y_, theta_[0], u_[0], u_[1], u_[2], heat_}; }
    const std::vector<double>& angles() const { return theta_; }  // of the links, rad
    double kinetic() const;                // energy of links, wheels and rotors, J
    double work() const { return work_; }  // work of the servos' torques since `place`, J
    // x, y of the centre and angle of every link, in the frame of the room.
    std::vector<double> places();

  private:
    struct Row {
        std::vector<double> row;
        double offset = 0;
        double speed = 0;  // row.u + offset at the end of the last step
    };
    struct Contact : Row {
        std::vector<double> response;           // change of u by an impulse of 1
        double mass = 0;                        // impulse per speed, kg or kg m^2; 0: cannot move
        double viscous = 0;                     // viscous coefficient, N s/m, times the step, s
        double impulse = 0, low = 0, high = 0;  // N s or N m s, and its bounds in this step
    };

    bool step(double h);
    void turn_joints(double h);
    void update_duties(double h);
    void set_wheel_rows(double h);
    const std::vector<double>& wheel_speeds(const std::vector<double>& rate);
    void add_bodies(double h);
    void add_servos(double h);
    void add_friction(double h);
    bool solve();
    void set_speeds();
    void restart();
    void set_directions(const std::vector<double>& angle);
    void add_square(const Row& row, double weight, double target);
    Contact& gear(int joint) { return contact_[2 * n_ + joint]; }
    double joint_angle(int i) const { return theta_[i + 1] - theta_[i]; }

    Robot robot_;
    std::vector<LabLink> links_;
    std::optional<Servo> servo_;
    int n_;
    int size_;  // number of unknowns u
    Slope slope_;
    bool guided_ = false;
    double ground_x_ = 0, ground_y_ = 0;  // velocity of the ground, m/s
    double x_ = 0, y_ = 0;                // centre of mass, m
    double heat_ = 0, work_ = 0;          // J
    double since_update_ = 0;             // time since the last update of the servos' loops, s
    std::vector<double> theta_;           // angles of the links, rad
    std::vector<double> vx_, vy_;         // velocities of the links after the last step, m/s
    // Of the joints: goal, rad; greatest rate, rad/s; duty, -1 to 1; torque without gear friction,
    // N m.
    std::vector<double> goal_, max_rate_, duty_, torque_;
    std::vector<double> imposed_rate_;           // rates of the links relative to link 1, rad/s
    std::vector<std::vector<double>> rates_by_;  // d rates of the links / d each rate in u
    std::vector<double> u_, mass_, right_, c_, s_, speeds_;
    std::vector<Row> link_;         // rates of the links
    std::vector<Contact> contact_;  // wheels along and across each link, then gears
};

}  // namespace serpenoid
