// The implicit model with imposed joint torques, for implicit methods (stiff_link.hpp): blocks of
// x, y and theta.
#pragma once

#include <memory>
#include <vector>

#include "methods/stiff/stiff_link.hpp"
#include "numerics/block_tridiagonal.hpp"
#include "scene/make_system.hpp"
#include "scene/run_request.hpp"

namespace serpenoid {

// Coordinates, link by link: x, y of link 1 or of the gap behind the link, then theta. In tangent
// vectors (`lift`, `drop`) x, y of the link itself.
class SpringTorque {
  public:
    template <class Scalar>
    using Matrix = BlockTridiagonal<3, false, Scalar>;

    explicit SpringTorque(const RunRequest& q)
        : r_(q.robot),
          k_(q.spring.k),
          c_(q.spring.c),
          law_(q.ground, q.smoothing),
          weight_x_(r_.m * q.slope.gx),
          weight_y_(r_.m * q.slope.gy),
          source_(make_torques(q)),
          servo_(q.drive == Drive::servo),
          time_(kMoments),
          torque_(kMoments, std::vector<double>(r_.n - 1)),
          by_angle_(r_.n - 1),
          by_rate_(r_.n - 1),
          link_(r_.n),
          chain_(r_.n) {}

    int dim() const { return 3 * r_.n; }
    bool is_angle(int j) const { return j % 3 == 2; }
    bool is_gap(int j) const { return j >= 3 && !is_angle(j); }
    double mass(int j) const { return is_angle(j) ? r_.I : r_.m; }
    double lightest_turn() const { return r_.I; }

    // From and to the state of the system: x, y, vx, vy of all links, the angle of link 1 and those
    // of the joints, then their rates.
    void load(double, const double* y, double* q, double* v) const {
        const int n = r_.n;
        for (int i = 0; i < n; ++i) {
            q[3 * i + 2] = y[4 * n + i] + (i > 0 ? q[3 * i - 1] : 0);
            v[3 * i + 2] = y[5 * n + i] + (i > 0 ? v[3 * i - 1] : 0);
        }
        to_gaps(n, 3, y, q, v, [&](int i) { return arm_behind(i, q, v); });
    }
    void store(double, const double* q, const double* v, double* y) const {
        const int n = r_.n;
        for (int i = 0; i < n; ++i) {
            y[4 * n + i] = q[3 * i + 2] - (i > 0 ? q[3 * i - 1] : 0);
            y[5 * n + i] = v[3 * i + 2] - (i > 0 ? v[3 * i - 1] : 0);
        }
        to_centres(n, 3, q, v, y, [&](int i) { return arm_behind(i, q, v); });
    }

    void enter(double t) { source_->enter(t, chain_); }
    void at(int moment, double t) {
        time_[moment] = t;
        if (!servo_) source_->torques(t, chain_, torque_[moment].data());
    }
    void keep_last_moment() {
        std::swap(torque_[0], torque_[kMoments - 1]);
        time_[0] = time_[kMoments - 1];
    }

    // M a - force, link by link, for places q, rates v, accelerations a.
    void residual(int moment, const double* q, const double* v, const double* a, double* r) {
        if (servo_) servo_torques(moment, q, v, 0, 0, torque_[moment]);
        const std::vector<double>& torque = torque_[moment];
        double px = 0, py = 0, pT = 0;  // of the joint behind
        LinkMotion back = link(0, q, v, a);
        back.vx = v[0], back.vy = v[1], back.ax = a[0], back.ay = a[1];
        for (int i = 0;; ++i) {
            const bool last = i + 1 == r_.n;
            const int g = 3 * i + 3;
            const double fx = last ? 0 : k_ * q[g] + c_ * v[g];
            const double fy = last ? 0 : k_ * q[g + 1] + c_ * v[g + 1];
            const double T = last ? 0 : torque[i];
            const LinkFriction ground(law_, back);
            r[3 * i] = r_.m * back.ax - ground.x() - weight_x_ + px - fx;
            r[3 * i + 1] = r_.m * back.ay - ground.y() - weight_y_ + py - fy;
            r[3 * i + 2] =
                r_.I * back.dw + pT - T - r_.l * (back.c * (py + fy) - back.s * (px + fx));
            if (last) return;
            LinkMotion front = link(i + 1, q, v, a);
            front.follow(back, r_.l, v[g], v[g + 1], a[g], a[g + 1]);
            px = fx, py = fy, pT = T, back = front;
        }
    }

    // Note the derivatives at a state, with the gaps of another (see SpringAngle).
    void linearize(int moment, const double* q, const double* v, const double* gaps) {
        if (servo_) servo_slopes(moment, q, v);
        LinkMotion back{};
        for (int i = 0; i < r_.n; ++i) {
            LinkMotion k = link(i, q, v, v);
            if (i > 0)
                k.follow(back, r_.l, v[3 * i], v[3 * i + 1], 0, 0);
            else
                k.vx = v[0], k.vy = v[1];
            double gx = 0, gy = 0;
            for (int g : {3 * i, 3 * i + 3})
                if (g > 0 && g < 3 * r_.n) gx += gaps[g], gy += gaps[g + 1];
            link_[i] = {LinkFriction(law_, k).slope(law_), -r_.l * k.s, r_.l * k.c,
                        k_ * r_.l * (k.c * gx + k.s * gy)};
            back = k;
        }
    }

    // M s^2 - s dforce/drate - dforce/dplace on tangent vectors.
    template <class Scalar>
    void assemble(Scalar s, Matrix<Scalar>& to) const {
        const Scalar square = s * s, stiff = k_ + c_ * s;
        for (int i = 0; i < r_.n; ++i) {
            const LinkSlope& a = link_[i];
            const double behind = i > 0, ahead = i + 1 < r_.n;
            const Scalar own = r_.m * square + (ahead + behind) * stiff;
            const Scalar nx = ((ahead - behind) * a.nx) * stiff;
            const Scalar ny = ((ahead - behind) * a.ny) * stiff;
            const Scalar next = i + 1 < r_.n ? servo(i, s) : Scalar(0);
            const Scalar turn = r_.I * square + ((ahead + behind) * r_.l * r_.l) * stiff +
                                Scalar(a.pull) + next + (i > 0 ? servo(i - 1, s) : Scalar(0));
            const FrictionSlope& d = a.friction;
            to.diagonal[i] = {own - d.xx * s, -(d.xy * s), nx - d.tx, -(d.xy * s), own - d.yy * s,
                              ny - d.ty,      nx,          ny,        turn};
            if (i + 1 == r_.n) return;
            const LinkSlope& b = link_[i + 1];
            const Scalar both = (a.nx * b.nx + a.ny * b.ny) * stiff - next;
            to.upper[i] = {
                -stiff,          0,   b.nx * stiff, 0, -stiff, b.ny * stiff, -(a.nx * stiff),
                -(a.ny * stiff), both};
            to.lower[i + 1] = {
                -stiff,       0,   -(a.nx * stiff), 0, -stiff, -(a.ny * stiff), b.nx * stiff,
                b.ny * stiff, both};
        }
    }

    // f -= dforce/drate v for a tangent vector v.
    void subtract_damping(const double* v, double* f) const {
        for (int i = 0; i < r_.n; ++i) {
            const LinkSlope& a = link_[i];
            const FrictionSlope& d = a.friction;
            const double *u = v + 3 * i, *w = u + 3;
            double* to = f + 3 * i;
            to[0] -= d.xx * u[0] + d.xy * u[1];
            to[1] -= d.xy * u[0] + d.yy * u[1];
            if (i + 1 == r_.n) return;
            const LinkSlope& b = link_[i + 1];
            const double ux = c_ * (w[0] - u[0] - a.nx * u[2] - b.nx * w[2]);
            const double uy = c_ * (w[1] - u[1] - a.ny * u[2] - b.ny * w[2]);
            to[0] -= ux, to[1] -= uy, to[2] -= a.nx * ux + a.ny * uy;
            to[3] += ux, to[4] += uy, to[5] -= b.nx * ux + b.ny * uy;
            const double brake = by_rate_[i] * (w[2] - u[2]);
            to[2] -= brake, to[5] += brake;
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

  private:
    struct LinkSlope {
        FrictionSlope friction;
        double nx, ny;  // l n_i
        double pull;    // what turning it under the forces adds
    };

    LinkMotion link(int i, const double* q, const double* v, const double* a) const {
        const int j = 3 * i + 2;
        return {std::cos(q[j]), std::sin(q[j]), v[j], a[j], 0, 0, 0, 0};
    }
    Arm arm_behind(int i, const double* q, const double* v) const {
        return {link(i - 1, q, v, v), link(i, q, v, v), r_.l};
    }
    template <class Scalar>
    void shift(int i, Scalar* u, double sign) const {
        const LinkSlope &a = link_[i], &b = link_[i + 1];
        const Scalar* from = u + 3 * i;
        Scalar* to = u + 3 * i + 3;
        to[0] += sign * (from[0] + a.nx * from[2] + b.nx * to[2]);
        to[1] += sign * (from[1] + a.ny * from[2] + b.ny * to[2]);
    }

    // What a servo's torque adds along the diagonal for its two links.
    template <class Scalar>
    Scalar servo(int joint, Scalar s) const {
        return by_angle_[joint] + by_rate_[joint] * s;
    }
    void servo_torques(int moment, const double* q, const double* v, double angle, double rate,
                       std::vector<double>& to) {
        for (int i = 0; i < r_.n; ++i) {
            chain_.theta[i] = q[3 * i + 2] + i * angle;
            chain_.omega[i] = v[3 * i + 2] + i * rate;
        }
        source_->torques(time_[moment], chain_, to.data());
    }
    // A servo's torque depends on its own joint alone: turn all joints at once. Differences, as
    // limits and dead band have kinks.
    void servo_slopes(int moment, const double* q, const double* v) {
        constexpr double kAngle = 1e-6, kRate = 1e-5;
        std::vector<double>& torque = torque_[moment];
        servo_torques(moment, q, v, 0, 0, torque);
        servo_torques(moment, q, v, kAngle, 0, by_angle_);
        servo_torques(moment, q, v, 0, kRate, by_rate_);
        for (int i = 0; i + 1 < r_.n; ++i) {
            by_angle_[i] = (by_angle_[i] - torque[i]) / kAngle;
            by_rate_[i] = (by_rate_[i] - torque[i]) / kRate;
        }
    }

    Robot r_;
    double k_, c_;
    SmoothLaw law_;
    double weight_x_, weight_y_;
    std::unique_ptr<TorqueSource> source_;
    bool servo_;  // torques depend on the state
    std::vector<double> time_;
    std::vector<std::vector<double>> torque_;
    std::vector<double> by_angle_, by_rate_;  // of T_i by the joint's angle and rate
    std::vector<LinkSlope> link_;
    Chain chain_;
};

}  // namespace serpenoid
