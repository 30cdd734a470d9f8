// The three things every model is made of, in SI units and radians; Python has checked the ranges.
#pragma once

#include <algorithm>
#include <initializer_list>
#include <vector>

// The small parts of which a right-hand side is composed: with dozens of compositions in one
// translation unit the compiler's own judgement leaves calls in the loops (a tenth of their cost).
#define INLINED [[gnu::always_inline]] inline

namespace serpenoid {

// A chain of n equal rigid links, counted from the tail.
struct Robot {
    int n;     // links, 2 or more
    double m;  // mass of a link, kg
    double l;  // HALF the length of a link, m (the paper's l)
    double I;  // inertia of a link about its centre, kg m^2
};

// Friction at the centre of one link, along it (t) and across it (n); Eqs. 28, 29, 59, 62. On a
// ratchet it is another backwards (towards the tail) than forwards along the link.
struct Ground {
    double ct, cn;                        // viscous, N s/m
    double ft0, fn0;                      // dry, N
    double ct_back = ct, ft0_back = ft0;  // backwards
    bool dry() const { return ft0 > 0 || ft0_back > 0 || fn0 > 0; }
    bool viscous() const { return ct > 0 || ct_back > 0 || cn > 0; }
    bool ratchet() const { return ct != ct_back || ft0 != ft0_back; }
    bool smooth() const { return !dry() && ct == ct_back; }  // a smooth function of the speed

    // The dry force along a link is `thrust`, and -ft0_mean sgn v with its whole interval at rest.
    double ft0_mean() const { return ft0 == ft0_back ? ft0 : 0.5 * (ft0 + ft0_back); }
    double thrust() const { return 0.5 * (ft0_back - ft0); }
    double ct_mean() const { return ct == ct_back ? ct : 0.5 * (ct + ct_back); }
    // By which way a wheel goes; 0 where it rests.
    double ct_going(double way) const { return way > 0 ? ct : way < 0 ? ct_back : ct_mean(); }
    // ft0_mean over the force that is little or much to a wheel that rests: the weaker bound, or
    // the force that `moves` the links where the stronger one is next to no bound at all.
    double grip(double moves) const {
        if (ft0 == ft0_back) return 1;
        const double weak = std::min(ft0, ft0_back), strong = std::max(ft0, ft0_back);
        return ft0_mean() / std::min(strong, std::max(weak, moves));
    }
    // The least force at which any wheel gives way; 0 without dry friction.
    double least_dry() const {
        double least = 0;
        for (const double f : {ft0, ft0_back, fn0})
            if (f > 0 && (least == 0 || f < least)) least = f;
        return least;
    }
};

// Acceleration of gravity along the plane of the ground, m/s^2, ground frame; 0 on the level.
struct Slope {
    double gx = 0, gy = 0;
    bool tilted() const { return gx != 0 || gy != 0; }
};

// Joint angles phi_i = offset + gain_i alpha sin(omega t + (i - 1) beta + shift_i), i = 1..n-1;
// Eq. 57, where every gain is 1 and every shift 0 (empty lists).
struct Gait {
    double alpha, beta;  // rad
    double omega;        // rad/s
    double offset;       // rad
    std::vector<double> gain{}, shift{};
};

}  // namespace serpenoid
