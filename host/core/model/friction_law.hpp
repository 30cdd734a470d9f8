// Friction of wheels: the law of one direction of a wheel, and the ground under all of them.
#pragma once

#include <algorithm>

namespace serpenoid {

// The set-valued law of one direction of a wheel: the force -(c v + F0 sgn v), with c and F0 by the
// sign of v, and at rest any force between both ends (Eqs. 28, 29, 59 and 62). At rest the force is
// thrust - bound s with s in [-1, 1]; where the wheel slides, s is the sign of v. A step that keeps
// c has the potential c v^2/2 + bound |v| - thrust v, whose minimum convex problems look for.
struct WheelLaw {
    double c, f0;                     // viscous, N s/m; dry, N
    double c_back = c, f0_back = f0;  // backwards (on a ratchet: towards the tail)

    double bound() const { return (f0 + f0_back) / 2; }   // N
    double thrust() const { return (f0_back - f0) / 2; }  // N

    // The force at a speed, with sgn 0 = 0: a single evaluation, which knows nothing of sticking.
    double force(double speed) const {
        if (speed == 0) return 0;
        return speed < 0 ? f0_back - c_back * speed : -f0 - c * speed;
    }

    // c by the direction in which the wheel goes; 0: at rest, the mean of both.
    double viscous(double direction) const {
        return direction > 0 ? c : direction < 0 ? c_back : (c + c_back) / 2;
    }

    // F0 by the direction in which the wheel goes or would go.
    double dry(double direction) const { return direction < 0 ? f0_back : f0; }

    // Whether something changes when the wheel stops.
    bool has_modes() const { return bound() > 0 || c != c_back; }

    // The bound over the scale of forces on a wheel at rest: its weaker end, or the force that
    // would move the links if that is larger, but at most the stronger end.
    double breakaway_ratio(double force_scale) const {
        if (f0 == f0_back) return 1;
        const auto [weak, strong] = std::minmax({f0, f0_back});
        return bound() / std::min(strong, std::max(weak, force_scale));
    }

    // The least force at which a wheel that rests gives way; 0 without dry friction.
    double breakaway_force() const { return smaller_force(f0, f0_back); }

    // The smaller one of two forces that are not 0.
    static double smaller_force(double a, double b) {
        return a == 0 || b == 0 ? std::max(a, b) : std::min(a, b);
    }
};

// Friction at the centre of one link.
struct Ground {
    WheelLaw along, across;
    bool dry() const { return along.bound() > 0 || across.bound() > 0; }
    // Whether forces are smooth functions of the speeds.
    bool smooth() const { return !along.has_modes() && !across.has_modes(); }
    double breakaway_force() const {
        return WheelLaw::smaller_force(along.breakaway_force(), across.breakaway_force());
    }
};

}  // namespace serpenoid
