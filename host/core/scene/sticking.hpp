// Set-valued dry friction for explicit mechanics: wheels rest or slide.
//
// Every link has two directions, along and across, in which it rests or slides one way or the
// other: the mode. A direction that slides has its dry force; those that rest have the forces z mu,
// |z| <= 1, that keep them at rest. Accelerations are linear in the forces, so with G the wheels'
// directions, W = G M^-1 G^T (one solution of the system for each resting direction) and a the
// acceleration of the directions without those forces, they solve  W mu z = -a:  in a mode the
// motion is smooth, and methods of high order step it.
//
// At the end of a mode the forces on all that is at rest are found anew: they minimise
//     1/2 (mu z).W (mu z) + (mu z).a  over |z| <= 1     (box_quadratic.hpp),
// which is Gauss's principle of least constraint with dry friction in it. A contact whose force is
// inside its bound rests; one at its bound slides, against the force. There is no smoothing width.
//
// Gears hold like wheels: the speed of such a contact is that of its joint times a link's length,
// its force the torque over that length.
//
// A ratchet's links have the mean of both directions as mu and half the difference as a constant
// thrust; its viscous friction is that of the mode, and a wheel without dry friction reverses when
// it stops, without a rest.
#pragma once

#include <vector>

#include "model/friction_law.hpp"
#include "numerics/box_quadratic.hpp"
#include "scene/mechanics.hpp"

namespace serpenoid {

class Sticking {
  public:
    // The mechanics have all but the dry friction, and the mean viscous friction of a ratchet.
    Sticking(Mechanics& mechanics, const RunRequest& request);

    // The chain with all its forces, in the present modes.
    void forces(double t, const double* y);
    // Find the modes that follow on a state; what rests in them is put to rest in it.
    void find(double t, double* y);
    // How far each part is from the end of its mode: negative beyond, -1 the aim when it ends.
    void margins(double t, const double* y, std::vector<double>& margin);
    // Whether what rests has crept by the errors of the steps, and is to be found anew.
    bool creeps(double t, const double* y);

  private:
    enum class Kind : char { along, across, gear };
    struct Contact {
        int link;  // of a gear: behind it
        Kind kind;
        double dry;              // bound of its force, N
        double breakaway_ratio;  // friction_law.hpp
        int sign = 0;            // 0 rests, else which way it slides
        double share = 0;        // of the bound, while it rests
        double wrong = 0;        // speed against its sign at the start of the mode, m/s
    };
    double speed(const Contact& w) const;
    double acceleration(const Contact& w) const;
    void add_force(const Contact& w, double part);
    void release();
    void find_shares(double t, const double* y);
    void slide(double t, const double* y);
    void add_ratchet(const Contact& w);
    void respond(const std::vector<int>& which);
    void hold(const std::vector<int>& which);
    bool others_hold();
    double excess(const std::vector<double>& share, std::size_t i) const;
    void put_to_rest(const std::vector<int>& which, double* y);

    Mechanics& mechanics_;
    Chain& chain_;
    WheelLaw along_;
    double length_;           // of a link, m
    double at_rest_;          // m/s: slower than this, a wheel may rest
    bool has_modes_ = false;  // modes have been found before
    std::vector<Contact> contacts_;
    std::vector<int> resting_;
    BoxQuadratic box_;
    std::vector<double> response_, pull_, share_, free_x_, free_y_, free_T_, free_acceleration_;
};

}  // namespace serpenoid
