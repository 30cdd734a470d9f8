// The implicit model with imposed joint angles, for implicit methods (stiff_link.hpp): blocks of
// x and y, bordered by theta_1, which turns all links at once.
#pragma once

#include <array>
#include <vector>

#include "methods/stiff/stiff_link.hpp"
#include "model/gait.hpp"
#include "numerics/block_tridiagonal.hpp"
#include "scene/run_request.hpp"

namespace serpenoid {

// Coordinates: x, y of link 1, then of every gap; then theta_1. In tangent vectors (`lift`, `drop`)
// x, y of every link instead.
class SpringAngle {
  public:
    template <class Scalar>
    using Matrix = BlockTridiagonal<2, true, Scalar>;

    explicit SpringAngle(const RunRequest& q)
        : r_(q.robot),
          k_(q.spring.k),
          c_(q.spring.c),
          weight_x_(r_.m * q.slope.gx),
          weight_y_(r_.m * q.slope.gy),
          w_(q.gait.omega),
          law_(q.ground, q.smoothing),
          gait_(r_.n, q.gait),
          shapes_(kMoments + 1, Pose(r_.n)),
          friction_(r_.n),
          arm_(r_.n - 1) {}

    int dim() const { return 2 * r_.n + 1; }
    bool is_angle(int j) const { return j == 2 * r_.n; }
    double mass(int j) const { return is_angle(j) ? r_.n * r_.I : r_.m; }
    double lightest_turn() const { return r_.n * r_.I; }
    bool is_gap(int j) const { return j >= 2 && !is_angle(j); }

    // From and to the state of the system: x, y, vx, vy of all links, theta_1 and its rate.
    void load(double t, const double* y, double* q, double* v) {
        const int n = r_.n;
        q[2 * n] = y[4 * n], v[2 * n] = y[4 * n + 1];
        at(kMoments, t);
        const Turn turn(q[2 * n], v[2 * n], 0);
        to_gaps(n, 2, y, q, v, [&](int i) { return arm_behind(i, turn); });
    }
    void store(double t, const double* q, const double* v, double* y) {
        const int n = r_.n;
        y[4 * n] = q[2 * n], y[4 * n + 1] = v[2 * n];
        at(kMoments, t);
        const Turn turn(q[2 * n], v[2 * n], 0);
        to_centres(n, 2, q, v, y, [&](int i) { return arm_behind(i, turn); });
    }

    void enter(double) {}

    // Tabulate what depends on the time alone.
    void at(int moment, double t) {
        Pose& shape = shapes_[moment];
        const double sin_tau = std::sin(w_ * t), cos_tau = std::cos(w_ * t);
        double angle = 0, rate = 0, accel = 0;
        shape.accels = 0;
        for (int i = 0;; ++i) {
            shape.link[i] = {std::cos(angle), std::sin(angle), rate, accel};
            shape.accels += accel;
            if (i + 1 == r_.n) return;
            const GaitTable::Joint joint = gait_.at(i, sin_tau, cos_tau);
            angle += joint.angle, rate += w_ * joint.slope, accel += w_ * w_ * joint.curvature;
        }
    }
    void keep_last_moment() { std::swap(shapes_[0], shapes_[kMoments - 1]); }

    // M a - force, link by link, for places q, rates v, accelerations a.
    void residual(int moment, const double* q, const double* v, const double* a, double* r) const {
        const int n = r_.n;
        const Turn turn(q[2 * n], v[2 * n], a[2 * n]);
        double px = 0, py = 0, couple = 0;
        LinkMotion back = turn.of(shapes_[moment].link[0]);
        back.vx = v[0], back.vy = v[1], back.ax = a[0], back.ay = a[1];
        for (int i = 0;; ++i) {
            const LinkFriction ground(law_, back);
            r[2 * i] = r_.m * back.ax - ground.x() - weight_x_ + px;
            r[2 * i + 1] = r_.m * back.ay - ground.y() - weight_y_ + py;
            if (i + 1 == n) break;
            const int g = 2 * i + 2;
            LinkMotion front = turn.of(shapes_[moment].link[i + 1]);
            front.follow(back, r_.l, v[g], v[g + 1], a[g], a[g + 1]);
            px = k_ * q[g] + c_ * v[g], py = k_ * q[g + 1] + c_ * v[g + 1];
            r[2 * i] -= px, r[2 * i + 1] -= py;
            couple += r_.l * (py * (front.c + back.c) - px * (front.s + back.s));
            back = front;
        }
        r[2 * n] = r_.I * (n * a[2 * n] + shapes_[moment].accels) - couple;
    }

    // Note the derivatives at a state, with the gaps of another: predicted ones are of the size of
    // the prediction's error, many times the true ones.
    void linearize(int moment, const double* q, const double* v, const double* gaps) {
        const int n = r_.n;
        const Turn turn(q[2 * n], v[2 * n], 0);
        LinkMotion back = turn.of(shapes_[moment].link[0]);
        back.vx = v[0], back.vy = v[1];
        pull_ = 0;
        for (int i = 0;; ++i) {
            friction_[i] = LinkFriction(law_, back).slope(law_);
            if (i + 1 == n) return;
            const int g = 2 * i + 2;
            LinkMotion front = turn.of(shapes_[moment].link[i + 1]);
            front.follow(back, r_.l, v[g], v[g + 1], 0, 0);
            arm_[i] = {-r_.l * (front.s + back.s), r_.l * (front.c + back.c)};
            pull_ += k_ * (arm_[i][1] * gaps[g] - arm_[i][0] * gaps[g + 1]);
            back = front;
        }
    }

    // M s^2 - s dforce/drate - dforce/dplace on tangent vectors.
    template <class Scalar>
    void assemble(Scalar s, Matrix<Scalar>& to) const {
        const int n = r_.n;
        const Scalar inertial = r_.m * (s * s), stiff = k_ + c_ * s;
        to.corner = (n * r_.I) * (s * s) + Scalar(pull_);
        double bx = 0, by = 0;  // the arm of the joint behind
        for (int i = 0; i < n; ++i) {
            const FrictionSlope& d = friction_[i];
            const Scalar own = inertial + (i == 0 || i + 1 == n ? 1.0 : 2.0) * stiff;
            to.diagonal[i] = {own - d.xx * s, -(d.xy * s), -(d.xy * s), own - d.yy * s};
            to.lower[i] = to.upper[i] = {-stiff, 0, 0, -stiff};
            const double ax = i + 1 < n ? arm_[i][0] : 0, ay = i + 1 < n ? arm_[i][1] : 0;
            to.corner += (ax * ax + ay * ay) * stiff;
            const Scalar x = (ax - bx) * stiff, y = (ay - by) * stiff;
            to.row[2 * i] = x, to.row[2 * i + 1] = y;
            to.column[2 * i] = x - d.tx, to.column[2 * i + 1] = y - d.ty;
            bx = ax, by = ay;
        }
    }

    // f -= dforce/drate v for a tangent vector v.
    void subtract_damping(const double* v, double* f) const {
        const int n = r_.n;
        for (int i = 0; i < n; ++i) {
            const FrictionSlope& d = friction_[i];
            f[2 * i] -= d.xx * v[2 * i] + d.xy * v[2 * i + 1];
            f[2 * i + 1] -= d.xy * v[2 * i] + d.yy * v[2 * i + 1];
            if (i + 1 == n) return;
            const double ux = c_ * (v[2 * i + 2] - v[2 * i] - arm_[i][0] * v[2 * n]);
            const double uy = c_ * (v[2 * i + 3] - v[2 * i + 1] - arm_[i][1] * v[2 * n]);
            f[2 * i] -= ux, f[2 * i + 1] -= uy, f[2 * i + 2] += ux, f[2 * i + 3] += uy;
            f[2 * n] -= arm_[i][0] * ux + arm_[i][1] * uy;
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
    struct LinkAngle {
        double c, s, rate, accel;  // of theta_i - theta_1
    };
    struct Pose {
        explicit Pose(int n) : link(n) {}
        std::vector<LinkAngle> link;
        double accels = 0;  // sum of theta_i'' - theta_1''
    };
    // How link 1 turns, and so all others.
    struct Turn {
        Turn(double angle, double w, double dw)
            : c(std::cos(angle)), s(std::sin(angle)), w(w), dw(dw) {}
        LinkMotion of(const LinkAngle& a) const {
            return {c * a.c - s * a.s, s * a.c + c * a.s, w + a.rate, dw + a.accel, 0, 0, 0, 0};
        }
        double c, s, w, dw;
    };

    Arm arm_behind(int i, const Turn& turn) const {  // at kMoments
        const std::vector<LinkAngle>& link = shapes_[kMoments].link;
        return {turn.of(link[i - 1]), turn.of(link[i]), r_.l};
    }
    template <class Scalar>
    void shift(int i, Scalar* u, double sign) const {
        for (int axis : {0, 1})
            u[2 * i + 2 + axis] += sign * (u[2 * i + axis] + arm_[i][axis] * u[2 * r_.n]);
    }

    Robot r_;
    double k_, c_, weight_x_, weight_y_, w_;
    SmoothLaw law_;
    GaitTable gait_;
    std::vector<Pose> shapes_;
    std::vector<FrictionSlope> friction_;
    std::vector<std::array<double, 2>> arm_;  // l (n_i + n_{i+1}), what a turn moves a gap by
    double pull_ = 0;                         // what turning the arms under the forces adds
};

}  // namespace serpenoid
