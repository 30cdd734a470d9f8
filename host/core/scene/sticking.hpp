// Set-valued dry friction for explicit mechanics: every contact rests or slides.
//
// Every link has two contacts, along and across, each of which rests, slides forwards or slides
// backwards: the mode. A sliding contact has its dry friction; resting ones have the forces z mu,
// |z| <= 1, that keep them at rest. Accelerations are linear in the forces. With the directions G
// of the resting contacts, W = G M^-1 G^T (one solution of the system for each of them), and their
// accelerations a without these forces, the forces solve  W mu z = -a.  Within a mode the motion is
// smooth, and methods of high order apply.
//
// At the end of a mode the forces on the contacts at rest are computed again: they minimise
//     1/2 (mu z).W (mu z) + (mu z).a  over |z| <= 1     (box_quadratic.hpp),
// which is Gauss's principle of least constraint with dry friction in it. A contact whose force is
// inside its bound rests; one at its bound slides, against the force. There is no smoothing width.
//
// The dry friction of gears is treated in the same way: the speed of such a contact is the rate of
// its joint times the length of a link, its force the torque divided by this length.
//
// For a ratchet, mu is the mean of both directions, and half of their difference is a constant
// thrust. Its viscous friction is that of the mode. A wheel without dry friction reverses without
// resting.
#pragma once

#include <vector>

#include "model/friction_law.hpp"
#include "numerics/box_quadratic.hpp"
#include "scene/mechanics.hpp"

namespace serpenoid {

class Sticking {
  public:
    // mechanics: without dry friction, and with the mean viscous friction of a ratchet.
    Sticking(Mechanics& mechanics, const RunRequest& request);

    // Fill the chain with all forces in the present modes.
    void forces(double t, const double* y);
    // Find the modes after a state, and bring the resting contacts exactly to rest in it.
    void find_modes(double t, double* y);
    // The distance of every contact from the end of its mode; negative after it. Ends are located
    // at -1.
    void margins(double t, const double* y, std::vector<double>& margin);
    // Whether errors of the steps have moved a resting contact so much that find_modes must be
    // called.
    bool creeps(double t, const double* y);

  private:
    enum class Kind : char { along, across, gear };
    struct Contact {
        int link;  // for a gear: the link behind the joint
        Kind kind;
        double dry;                // bound of the force, N
        double breakaway_ratio;    // see friction_law.hpp
        int sign = 0;              // sign of the sliding speed; 0 at rest
        double share = 0;          // force over its bound, at rest
        double reverse_speed = 0;  // speed against the sign at the start of the mode, m/s
    };
    double speed(const Contact& contact) const;
    double acceleration(const Contact& contact) const;
    void add_force(const Contact& contact, double share);
    void remove_rest_forces();
    void find_shares(double t, const double* y);
    void load_sliding(double t, const double* y);
    void add_ratchet(const Contact& contact);
    void set_response(const std::vector<int>& indices);
    void add_rest_forces(const std::vector<int>& indices);
    bool find_bounded_shares();
    double excess(const std::vector<double>& share, std::size_t i) const;
    void put_to_rest(const std::vector<int>& indices, double* y);

    Mechanics& mechanics_;
    Chain& chain_;
    WheelLaw along_;
    double length_;           // length of a link, m
    double rest_speed_;       // speed below which a contact may rest, m/s
    bool has_modes_ = false;  // whether modes have been found before
    std::vector<Contact> contacts_;
    std::vector<int> resting_;
    BoxQuadratic box_;
    std::vector<double> response_, pull_, share_, free_x_, free_y_, free_T_, free_acceleration_;
};

}  // namespace serpenoid
