// What both robots of the lab share: links, the friction of their wheels, and a time step's
// contacts.
//
// Unknowns u: the velocity of the centre of mass in the frame of the room, then rates. The speed of
// a contact is row u + offset. A step of h minimises
//     u M u / 2 - b u + sum_contacts (impulse against the speed) |speed|
// where M and b hold masses and viscous friction. Everything dry gives an impulse within bounds,
// which sweeps over all contacts find (projected Gauss-Seidel): each in turn takes the impulse that
// leaves it no speed, or the bound.
//
// The law of friction stands here a second time, on purpose: the product's own law is another
// file's, so that an error in either makes lab and product disagree. Only the data types of robot,
// ground and slope, and Cholesky's factor, are shared.
#pragma once

#include <vector>

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
    void set_slope(double gx, double gy) { slope_ = {gx, gy}; }
    void set_ground_velocity(double x, double y) { ground_x_ = x, ground_y_ = y; }

  protected:
    struct Contact {
        std::vector<double> row, reach;           // reach: what an impulse of 1 adds to u
        double offset = 0, mass = 0;              // mass: against its impulse; 0: it moves nothing
        double viscous = 0;                       // N s/m times the step
        double impulse = 0, least = 0, most = 0;  // N s or N m s, and its bounds in this step
        double before = 0;                        // speed at the end of the last step
    };

    // Wheels along and across of every link, then `others`; u has `size` numbers.
    LabChain(const Robot& robot, std::vector<LabLink> links, int size, int others);

    // Links at these angles: the wheels' rows for the velocity of the centre.
    void point(const std::vector<double>& angle);
    // The speeds of all wheels where links turn at these rates about the resting centre of mass.
    const std::vector<double>& turning(const std::vector<double>& rate);
    // Add weight/2 (speed - target)^2 to what is minimised.
    void add_square(const Contact& contact, double weight, double target);
    void resist(double h);  // wheels: their spin, viscous friction, and bounds of dry impulses
    bool sweep();           // u and all impulses; false where there is no number
    void settle();          // speeds of contacts and links by u
    double kinetic(const std::vector<double>& rate) const;  // of links that turn so, and wheels

    Robot robot_;
    std::vector<LabLink> links_;
    int n_, size_;
    Slope slope_;
    double ground_x_ = 0, ground_y_ = 0;  // m/s
    double x_ = 0, y_ = 0, heat_ = 0;     // of the centre of mass, m; of the wheels' friction, J
    std::vector<double> vx_, vy_;         // of every link at the end of the last step, in the room
    std::vector<double> u_, mass_, right_, c_, s_, speeds_;
    std::vector<Contact> contact_;
};

}  // namespace serpenoid
