// Set-valued dry friction for explicit mechanics: every contact rests or slides.
//
// Every link has two contacts, along and across. A contact rests, slides forwards or slides
// backwards: this is its mode. A sliding contact has its dry friction mu. A resting one has the
// force z mu, |z| <= 1, that keeps it at rest; z is called its share. Accelerations are linear in
// the forces. Let G be the directions of the resting contacts, W = G M^-1 G^T (computed by one
// solution of the system a contact) and a their accelerations without these forces; then the shares
// solve  W mu z = -a.  While no mode changes, the motion is smooth, and methods of high order
// apply.
//
// When a mode ends, the forces on all contacts that are nearly at rest are computed again. They
// minimise
//     1/2 (mu z).W (mu z) + (mu z).a  over |z| <= 1     (box_quadratic.hpp),
// which is Gauss's principle of least constraint with dry friction. A contact with |z| < 1 rests;
// one with |z| = 1 slides against its force. There is no smoothing width.
//
// The dry friction of a gear is a contact too: its speed is the rate of the joint times the length
// of a link, and its force is the torque divided by this length.
//
// For a ratchet, mu is the mean of its two dry frictions, and half of their difference is a
// constant thrust. Its viscous friction is that of the direction in which it slides. A ratchet
// without dry friction does not rest when its speed changes sign.
#pragma once

#include <vector>

#include "model/friction_law.hpp"
#include "numerics/box_quadratic.hpp"
#include "scene/mechanics.hpp"

namespace serpenoid {

class Sticking {
  public:
    // The mechanics must be without dry friction, and with the mean viscous friction of a ratchet.
    Sticking(Mechanics& mechanics, const RunRequest& request);

    // Fill the chain with all forces in the present modes.
    void forces(double t, const double* y);
    // Find the modes that follow from the state y, and set the resting contacts' speeds in it to 0.
    void find_modes(double t, double* y);
    // Fill margin with a number for each contact that falls as the end of its mode approaches and
    // is negative after it. The end is found to within a number between -1 and 0.
    void margins(double t, const double* y, std::vector<double>& margin);
    // Whether step errors have given a resting contact so much speed that find_modes must be
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
        double share = 0;          // z: force over its bound, at rest
        double reverse_speed = 0;  // speed against the sign at the start of the mode, m/s
    };
    double speed(const Contact& contact) const;
    double acceleration(const Contact& contact) const;
    void add_force(const Contact& contact, double share);
    void remove_rest_forces();
    void find_shares(double t, const double* y);
    void load_free_forces(double t, const double* y);
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
    std::vector<double> response_, scaled_acceleration_, share_, free_x_, free_y_, free_T_,
        free_acceleration_;
};

}  // namespace serpenoid
