// The implicit model with imposed joint torques, for implicit methods: every link turns by itself.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "methods/stiff/spring_chain.hpp"
#include "scene/make_system.hpp"

namespace serpenoid {

class SpringTorque : public SpringChain<3> {
  public:
    explicit SpringTorque(const RunRequest& q)
        : SpringChain(q),
          source_(make_torques(q)),
          servo_(q.drive == Drive::servo),
          time_(kMoments),
          torque_(kMoments, std::vector<double>(r_.n - 1)),
          chain_(r_.n) {}

    // From and to the state of the system: x, y, vx, vy of all links, the angle of link 1 and those
    // of the joints, then their rates.
    void load(double, const double* y, double* q, double* v) {
        const int n = r_.n;
        for (int i = 0; i < n; ++i) {
            q[3 * i + 2] = y[4 * n + i] + (i > 0 ? q[3 * i - 1] : 0);
            v[3 * i + 2] = y[5 * n + i] + (i > 0 ? v[3 * i - 1] : 0);
        }
        turn_links(q, v, v);
        to_gaps(y, q, v);
    }
    void store(double, const double* q, const double* v, double* y) {
        const int n = r_.n;
        for (int i = 0; i < n; ++i) {
            y[4 * n + i] = q[3 * i + 2] - (i > 0 ? q[3 * i - 1] : 0);
            y[5 * n + i] = v[3 * i + 2] - (i > 0 ? v[3 * i - 1] : 0);
        }
        turn_links(q, v, v);
        to_centres(q, v, y);
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

    void residual(int moment, const double* q, const double* v, const double* a, double* r) {
        if (servo_) servo_torques(moment, q, v, 0, 0, torque_[moment]);
        turn_links(q, v, a);
        balance(torque_[moment].data(), q, v, a, r);
    }
    void linearize(int moment, const double* q, const double* v, const double* gaps) {
        if (servo_) servo_slopes(moment, q, v);
        turn_links(q, v, v);
        note_slopes(v, gaps);
    }

  private:
    void turn_links(const double* q, const double* v, const double* a) {
        for (int i = 0, j = 2; i < r_.n; ++i, j += 3)
            link_[i] = {std::cos(q[j]), std::sin(q[j]), v[j], a[j], 0, 0, 0, 0};
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

    std::unique_ptr<TorqueSource> source_;
    bool servo_;  // torques depend on the state
    std::vector<double> time_;
    std::vector<std::vector<double>> torque_;
    Chain chain_;
};

}  // namespace serpenoid
