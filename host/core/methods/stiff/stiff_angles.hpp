// The implicit model with imposed joint angles, for implicit methods: theta_1 turns all links.
#pragma once

#include <vector>

#include "methods/stiff/spring_chain.hpp"
#include "model/gait.hpp"

namespace serpenoid {

class SpringAngle : public SpringChain<2> {
  public:
    explicit SpringAngle(const RunRequest& q)
        : SpringChain(q),
          w_(q.gait.omega),
          gait_(r_.n, q.gait),
          poses_(kMoments + 1, std::vector<LinkAngle>(r_.n)) {}

    // From and to the state of the system: x, y, vx, vy of all links, theta_1 and its rate.
    void load(double t, const double* y, double* q, double* v) {
        const int n = r_.n;
        q[2 * n] = y[4 * n], v[2 * n] = y[4 * n + 1];
        at(kMoments, t);
        turn_links(kMoments, q, v, v);
        to_gaps(y, q, v);
    }
    void store(double t, const double* q, const double* v, double* y) {
        const int n = r_.n;
        y[4 * n] = q[2 * n], y[4 * n + 1] = v[2 * n];
        at(kMoments, t);
        turn_links(kMoments, q, v, v);
        to_centres(q, v, y);
    }

    void enter(double) {}

    // Tabulate what depends on the time alone.
    void at(int moment, double t) {
        const double sin_tau = std::sin(w_ * t), cos_tau = std::cos(w_ * t);
        double angle = 0, rate = 0, accel = 0;
        for (int i = 0;; ++i) {
            poses_[moment][i] = {std::cos(angle), std::sin(angle), rate, accel};
            if (i + 1 == r_.n) return;
            const GaitTable::Joint joint = gait_.at(i, sin_tau, cos_tau);
            angle += joint.angle, rate += w_ * joint.slope, accel += w_ * w_ * joint.curvature;
        }
    }
    void keep_last_moment() { std::swap(poses_[0], poses_[kMoments - 1]); }

    void residual(int moment, const double* q, const double* v, const double* a, double* r) {
        turn_links(moment, q, v, a);
        balance(nullptr, q, v, a, r);
    }
    void linearize(int moment, const double* q, const double* v, const double* gaps) {
        turn_links(moment, q, v, v);
        note_slopes(v, gaps);
    }

  private:
    struct LinkAngle {
        double c, s, rate, accel;  // of theta_i - theta_1
    };
    void turn_links(int moment, const double* q, const double* v, const double* a) {
        const int j = 2 * r_.n;
        const double c = std::cos(q[j]), s = std::sin(q[j]);
        for (int i = 0; i < r_.n; ++i) {
            const LinkAngle& k = poses_[moment][i];
            link_[i] = {
                c * k.c - s * k.s, s * k.c + c * k.s, v[j] + k.rate, a[j] + k.accel, 0, 0, 0, 0};
        }
    }

    double w_;
    GaitTable gait_;
    std::vector<std::vector<LinkAngle>> poses_;
};

}  // namespace serpenoid
