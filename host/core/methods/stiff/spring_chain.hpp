// The implicit model's forces, masses and derivatives for implicit methods (stiff_link.hpp),
// whatever turns its links.
#pragma once

#include <cmath>
#include <vector>

#include "methods/stiff/stiff_link.hpp"
#include "numerics/block_tridiagonal.hpp"
#include "scene/run_request.hpp"

namespace serpenoid {

constexpr int kMoments = 4;  // of a step: its start and its three stages

// Coordinates, link by link: x, y of link 1 or of the gap behind the link; then, with B = 3, its
// angle. With B = 2 all links turn with link 1, whose angle comes last: the equations of all angles
// are summed up, which borders the blocks. In tangent vectors (`lift`, `drop`) x, y of the link
// itself. Who derives from this gives the links' directions and turning in `link_`.
template <int B>
class SpringChain {
  public:
    template <class Scalar>
    using Matrix = BlockTridiagonal<B, B == 2, Scalar>;

    explicit SpringChain(const RunRequest& q)
        : r_(q.robot),
          link_(r_.n),
          by_angle_(r_.n - 1),
          by_rate_(r_.n - 1),
          k_(q.spring.k),
          c_(q.spring.c),
          weight_x_(r_.m * q.slope.gx),
          weight_y_(r_.m * q.slope.gy),
          ground_(q.ground),
          slope_(r_.n) {}

    int dim() const { return B * r_.n + (B == 2); }
    bool is_angle(int j) const { return B == 2 ? j == 2 * r_.n : j % 3 == 2; }
    bool is_gap(int j) const { return j >= B && !is_angle(j); }
    double mass(int j) const { return is_angle(j) ? lightest_turn() : r_.m; }
    double lightest_turn() const { return B == 2 ? r_.n * r_.I : r_.I; }

    // M s^2 - s dforce/drate - dforce/dplace on tangent vectors.
    template <class Scalar>
    void assemble(Scalar s, Matrix<Scalar>& to) const {
        const Scalar square = s * s, stiff = k_ + c_ * s;
        if constexpr (B == 2) {
            to.row.assign(2 * r_.n, 0), to.column.assign(2 * r_.n, 0);
            to.corner = 0;
        }
        for (int i = 0; i < r_.n; ++i) {
            const LinkSlope& a = slope_[i];
            const double behind = i > 0, ahead = i + 1 < r_.n;
            const Scalar own = r_.m * square + (ahead + behind) * stiff;
            const Scalar nx = ((ahead - behind) * a.nx) * stiff;
            const Scalar ny = ((ahead - behind) * a.ny) * stiff;
            const Scalar next = i + 1 < r_.n ? servo(i, s) : Scalar(0);
            const Scalar turn = r_.I * square + ((ahead + behind) * r_.l * r_.l) * stiff +
                                Scalar(a.pull) + next + (i > 0 ? servo(i - 1, s) : Scalar(0));
            const FrictionSlope& d = a.friction;
            put<Scalar>(to, i, i,
                        {own - d.xx * s, -(d.xy * s), nx - d.tx, -(d.xy * s), own - d.yy * s,
                         ny - d.ty, nx, ny, turn});
            if (i + 1 == r_.n) return;
            const LinkSlope& b = slope_[i + 1];
            const Scalar both = (a.nx * b.nx + a.ny * b.ny) * stiff - next;
            put<Scalar>(to, i, i + 1,
                        {-stiff, 0, b.nx * stiff, 0, -stiff, b.ny * stiff, -(a.nx * stiff),
                         -(a.ny * stiff), both});
            put<Scalar>(to, i + 1, i,
                        {-stiff, 0, -(a.nx * stiff), 0, -stiff, -(a.ny * stiff), b.nx * stiff,
                         b.ny * stiff, both});
        }
    }

    // f -= dforce/drate v for a tangent vector v.
    void subtract_damping(const double* v, double* f) const {
        for (int i = 0; i < r_.n; ++i) {
            const LinkSlope& a = slope_[i];
            const FrictionSlope& d = a.friction;
            const double *u = v + B * i, *w = u + B;
            double* to = f + B * i;
            to[0] -= d.xx * u[0] + d.xy * u[1];
            to[1] -= d.xy * u[0] + d.yy * u[1];
            if (i + 1 == r_.n) return;
            const LinkSlope& b = slope_[i + 1];
            const double ux = c_ * (w[0] - u[0] - a.nx * turn(v, i) - b.nx * turn(v, i + 1));
            const double uy = c_ * (w[1] - u[1] - a.ny * turn(v, i) - b.ny * turn(v, i + 1));
            const double brake = by_rate_[i] * (turn(v, i + 1) - turn(v, i));
            to[0] -= ux, to[1] -= uy, to[B] += ux, to[B + 1] += uy;
            turn(f, i) -= a.nx * ux + a.ny * uy + brake;
            turn(f, i + 1) -= b.nx * ux + b.ny * uy - brake;
        }
    }

    // Changes of the gaps to changes of the centres, and back.
    template <class Scalar>
    void lift(Scalar* u) const {
        for (int i = 0; i + 1 < r_.n; ++i) shift(i, u, 1.0);
    }
    template <class Scalar>
    void drop(Scalar* u) const {
        for (int i = r_.n - 1; i-- > 0;) shift(i, u, -1.0);
    }

  protected:
    // From all links' x, y, vx, vy in y to those of link 1 and of the gaps; and back.
    void to_gaps(const double* y, double* q, double* v) const {
        const int n = r_.n;
        for (int axis : {0, 1}) {
            const double *place = y + axis * n, *rate = place + 2 * n;
            q[axis] = place[0], v[axis] = rate[0];
            for (int i = 1; i < n; ++i) {
                q[B * i + axis] = place[i] - (place[i - 1] + bridge(i, axis));
                v[B * i + axis] = rate[i] - (rate[i - 1] + bridge_rate(i, axis));
            }
        }
    }
    void to_centres(const double* q, const double* v, double* y) const {
        const int n = r_.n;
        for (int axis : {0, 1}) {
            double *place = y + axis * n, *rate = place + 2 * n;
            place[0] = q[axis], rate[0] = v[axis];
            for (int i = 1; i < n; ++i) {
                place[i] = q[B * i + axis] + (place[i - 1] + bridge(i, axis));
                rate[i] = v[B * i + axis] + (rate[i - 1] + bridge_rate(i, axis));
            }
        }
    }

    // M a - force, link by link, for places q, rates v, accelerations a; no torque: nullptr.
    void balance(const double* torque, const double* q, const double* v, const double* a,
                 double* r) {
        move_links(v, a);
        if (B == 2) turn(r, 0) = 0;
        double px = 0, py = 0, pT = 0;  // of the joint behind
        for (int i = 0; i < r_.n; ++i) {
            const LinkMotion& k = link_[i];
            const bool last = i + 1 == r_.n;
            const int g = B * i + B;
            const double fx = last ? 0 : k_ * q[g] + c_ * v[g];
            const double fy = last ? 0 : k_ * q[g + 1] + c_ * v[g + 1];
            const double T = last || !torque ? 0 : torque[i];
            const LinkFriction friction(ground_, k);
            r[B * i] = r_.m * k.ax - friction.x() - weight_x_ + px - fx;
            r[B * i + 1] = r_.m * k.ay - friction.y() - weight_y_ + py - fy;
            const double couple = r_.I * k.dw + pT - T - r_.l * (k.c * (py + fy) - k.s * (px + fx));
            turn(r, i) = couple + (B == 2 ? turn(r, i) : 0);
            px = fx, py = fy, pT = T;
        }
    }

    // Note the derivatives at rates v, with these gaps: predicted ones are of the size of the
    // prediction's error, many times the true ones.
    void note_slopes(const double* v, const double* gaps) {
        move_links(v, v);
        for (int i = 0; i < r_.n; ++i) {
            const LinkMotion& k = link_[i];
            double gx = 0, gy = 0;
            for (int g : {B * i, B * i + B})
                if (g > 0 && g < B * r_.n) gx += gaps[g], gy += gaps[g + 1];
            slope_[i] = {LinkFriction(ground_, k).slope(), -r_.l * k.s, r_.l * k.c,
                         k_ * r_.l * (k.c * gx + k.s * gy)};
        }
    }

    Robot r_;
    std::vector<LinkMotion> link_;
    std::vector<double> by_angle_, by_rate_;  // of the torques by the joints' angles and rates

  private:
    struct LinkSlope {
        FrictionSlope friction;
        double nx, ny;  // l n_i
        double pull;    // what turning it under the forces adds
    };

    template <class Scalar>
    Scalar& turn(Scalar* u, int i) const {
        return u[B == 2 ? 2 * r_.n : 3 * i + 2];
    }
    // What the two halves of the links beside the joint behind link i bridge, and its rate.
    double bridge(int i, int axis) const {
        const LinkMotion &a = link_[i - 1], &b = link_[i];
        return r_.l * (axis == 0 ? a.c + b.c : a.s + b.s);
    }
    double bridge_rate(int i, int axis) const {
        const LinkMotion &a = link_[i - 1], &b = link_[i];
        return axis == 0 ? -r_.l * (a.s * a.w + b.s * b.w) : r_.l * (a.c * a.w + b.c * b.w);
    }
    // Velocities and accelerations of all centres from those of link 1 and of the gaps.
    void move_links(const double* v, const double* a) {
        LinkMotion& first = link_[0];
        first.vx = v[0], first.vy = v[1], first.ax = a[0], first.ay = a[1];
        for (int i = 1, g = B; i < r_.n; ++i, g += B)
            link_[i].follow(link_[i - 1], r_.l, v[g], v[g + 1], a[g], a[g + 1]);
    }
    // The block of link i's equations and link j's coordinates x, y, theta.
    template <class Scalar>
    static void put(Matrix<Scalar>& to, int i, int j, const Block<3, Scalar>& of) {
        Block<B, Scalar>& block = i == j ? to.diagonal[i] : i < j ? to.upper[i] : to.lower[i];
        if constexpr (B == 3) {
            block = of;
        } else {
            block = {of[0], of[1], of[3], of[4]};
            to.column[2 * i] += of[2], to.column[2 * i + 1] += of[5];
            to.row[2 * j] += of[6], to.row[2 * j + 1] += of[7];
            to.corner += of[8];
        }
    }
    template <class Scalar>
    void shift(int i, Scalar* u, double sign) const {
        const LinkSlope &a = slope_[i], &b = slope_[i + 1];
        const Scalar* from = u + B * i;
        Scalar *to = u + B * i + B, &own = turn(u, i), &next = turn(u, i + 1);
        to[0] += sign * (from[0] + a.nx * own + b.nx * next);
        to[1] += sign * (from[1] + a.ny * own + b.ny * next);
    }
    // What a servo's torque adds along the diagonal for its two links.
    template <class Scalar>
    Scalar servo(int joint, Scalar s) const {
        return by_angle_[joint] + by_rate_[joint] * s;
    }

    double k_, c_, weight_x_, weight_y_;
    Ground ground_;
    std::vector<LinkSlope> slope_;
};

}  // namespace serpenoid
