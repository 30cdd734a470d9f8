// The implicit model in the coordinates in which its stiff forces are linear, for implicit methods.
//
// Places are told by link 1, the gaps Delta_j and the angles: F_j = k Delta_j + c Delta_j' is then
// linear, gaps of size F/k stay exact, and a polynomial in time through them does not open the
// joints (through centres x_i, y_i it would: an index-3 problem, and order 3 instead of 5).
// The equations stay those of the links' centres: velocities and accelerations are carried along,
//     v_{i+1} = v_i + Delta_i' + l (n_i w_i + n_{i+1} w_{i+1}),
//     a_{i+1} = a_i + Delta_i'' + l (n_i w_i' + n_{i+1} w_{i+1}') - l (t_i w_i^2 + t_{i+1}
//     w_{i+1}^2),
// and the residual is M a - force. A small change u of the centres and angles, with s u the change
// of the rates that goes with it, makes
//     d F_j = (k + c s) [u_{j+1} - u_j - l (n_j dtheta_j + n_{j+1} dtheta_{j+1})],
// so M s^2 - d force is block-tridiagonal in the links.
#pragma once

#include <cmath>

#include "model/params.hpp"

namespace serpenoid {

// A link on its way: direction, turning; velocity and acceleration of its centre.
struct LinkMotion {
    double c, s, w, dw;
    double vx, vy, ax, ay;

    // Carry the centre over the joint behind this link; g is the gap: its rate and acceleration.
    void follow(const LinkMotion& back, double l, double gvx, double gvy, double gax, double gay) {
        vx = back.vx + gvx - l * (back.s * back.w + s * w);
        vy = back.vy + gvy + l * (back.c * back.w + c * w);
        ax = back.ax + gax - l * (back.s * back.dw + s * dw + back.c * back.w * back.w + c * w * w);
        ay = back.ay + gay + l * (back.c * back.dw + c * dw - back.s * back.w * back.w - s * w * w);
    }
};

// Derivatives of the friction on one link by its velocity (a symmetric block) and its angle.
struct FrictionSlope {
    double xx, xy, yy, tx, ty;
};

// Viscous friction on one link (Eqs. 28 and 29).
struct LinkFriction {
    LinkFriction(const Ground& ground, const LinkMotion& k)
        : c(k.c),
          s(k.s),
          ct(ground.ct),
          cn(ground.cn),
          vt(c * k.vx + s * k.vy),
          vn(c * k.vy - s * k.vx) {}
    double x() const { return cn * vn * s - ct * vt * c; }
    double y() const { return -(ct * vt * s + cn * vn * c); }
    FrictionSlope slope() const {
        const double along = (cn - ct) * vn, across = (cn - ct) * vt;
        return {-(ct * c * c + cn * s * s), (cn - ct) * c * s, -(ct * s * s + cn * c * c),
                along * c - across * s, along * s + across * c};
    }
    double c, s, ct, cn, vt, vn;
};

}  // namespace serpenoid
