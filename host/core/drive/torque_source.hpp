// Where joint torques come from when they are not the answer: a table, a function, or servos.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <vector>

#include "drive/firmware_gait.hpp"
#include "model/chain.hpp"
#include "model/params.hpp"

namespace serpenoid {

// Torque of every joint at a time, N m; throws through the run when it fails.
using TorqueFunction = std::function<void(double t_s, double* torque_nm)>;

class TorqueSource {
  public:
    virtual ~TorqueSource() = default;
    // Fill T (on link i from link i+1) from the time, the angles and the rates of the chain.
    virtual void torques(double t, const Chain& chain, double* T) = 0;
    virtual double next_jump(double) const { return std::numeric_limits<double>::infinity(); }
    virtual void enter(double) {}
};

class NoTorque final : public TorqueSource {
  public:
    void torques(double, const Chain& k, double* T) override { std::fill_n(T, k.n() - 1, 0.0); }
};

class FunctionTorque final : public TorqueSource {
  public:
    explicit FunctionTorque(TorqueFunction f) : f_(std::move(f)) {}
    void torques(double t, const Chain&, double* T) override { f_(t, T); }

  private:
    TorqueFunction f_;
};

// Torques at rising times, one row each, linear in between; the first and last rows hold outside.
struct TorqueRows {
    std::vector<double> t_s, torque_nm;
    bool empty() const { return t_s.empty(); }
};

class TableTorque final : public TorqueSource {
  public:
    explicit TableTorque(TorqueRows rows) : rows_(std::move(rows)) {}

    // The kinks of the table end a step: between them everything is smooth.
    double next_jump(double t) const override {
        const auto after = std::upper_bound(rows_.t_s.begin(), rows_.t_s.end(), t);
        return after == rows_.t_s.end() ? std::numeric_limits<double>::infinity() : *after;
    }
    void torques(double t, const Chain& k, double* T) override {
        const std::size_t joints = k.n() - 1, last = rows_.t_s.size() - 1;
        const std::size_t to =
            std::lower_bound(rows_.t_s.begin(), rows_.t_s.end(), t) - rows_.t_s.begin();
        const double* b = &rows_.torque_nm[std::min(to, last) * joints];
        if (to == 0 || to > last) return static_cast<void>(std::copy_n(b, joints, T));
        const double* a = b - joints;
        const double f = (t - rows_.t_s[to - 1]) / (rows_.t_s[to] - rows_.t_s[to - 1]);
        for (std::size_t i = 0; i < joints; ++i) T[i] = (1 - f) * a[i] + f * b[i];
    }

  private:
    TorqueRows rows_;
};

// A hobby servo: proportional and derivative action towards a setpoint that changes every 20 ms.
struct Servo {
    double stiffness = 0;     // N m/rad
    double damping = 0;       // N m s/rad
    double torque_limit = 0;  // N m, stalled; a motor's falls to 0 at the speed limit
    double speed_limit = 0;   // rad/s, unloaded
    double dead_band = 0;     // rad, error below which it does nothing
};

// Setpoints are those of the firmware's own code, held through each frame of 20 ms.
class ServoTorque final : public TorqueSource {
  public:
    ServoTorque(const Servo& servo, const Gait& gait, int links)
        : servo_(servo), gait_(gait), setpoint_(links - 1) {
        enter(0);
    }
    double next_jump(double t) const override {
        // a time within rounding of a frame's start is in that frame
        return (std::floor(t / kFrame + 1e-9) + 1) * kFrame;
    }
    void enter(double t) override {
        const auto frame = static_cast<std::uint64_t>(std::floor(t / kFrame + 1e-9));
        gait_.setpoints(frame, setpoint_.data(), setpoint_.size());
    }
    void torques(double, const Chain& k, double* T) override {
        for (std::size_t i = 0; i < setpoint_.size(); ++i) {
            const double angle = k.theta[i + 1] - k.theta[i], rate = k.omega[i + 1] - k.omega[i];
            double error = setpoint_[i] - angle;
            error -= std::clamp(error, -servo_.dead_band, servo_.dead_band);
            const double wanted = servo_.stiffness * error - servo_.damping * rate;
            // the straight line of a motor, both ways; braking has the whole torque
            const double speed = rate / servo_.speed_limit;
            const double most = servo_.torque_limit * std::min(1.0, 1 - speed);
            const double least = -servo_.torque_limit * std::min(1.0, 1 + speed);
            T[i] = -std::max(std::min(wanted, most), least);  // on link i; the head side gets -T
        }
    }

  private:
    static constexpr double kFrame = 0.02;  // s
    Servo servo_;
    FirmwareGait gait_;
    std::vector<double> setpoint_;
};

}  // namespace serpenoid
