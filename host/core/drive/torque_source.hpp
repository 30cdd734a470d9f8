// Sources of joint torques: a table, a function, or servos.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <vector>

#include "drive/firmware_gait.hpp"
#include "drive/servo.hpp"
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
    // A jump has been reached, with the chain as it is.
    virtual void handle_jump(double, const Chain&) {}
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
        const auto next_row = std::upper_bound(rows_.t_s.begin(), rows_.t_s.end(), t);
        return next_row == rows_.t_s.end() ? std::numeric_limits<double>::infinity() : *next_row;
    }
    void torques(double t, const Chain& k, double* T) override {
        const std::size_t joints = k.n() - 1, last = rows_.t_s.size() - 1;
        const std::size_t row =
            std::lower_bound(rows_.t_s.begin(), rows_.t_s.end(), t) - rows_.t_s.begin();
        const double* b = &rows_.torque_nm[std::min(row, last) * joints];
        if (row == 0 || row > last) return static_cast<void>(std::copy_n(b, joints, T));
        const double* a = b - joints;
        const double f = (t - rows_.t_s[row - 1]) / (rows_.t_s[row] - rows_.t_s[row - 1]);
        for (std::size_t i = 0; i < joints; ++i) T[i] = (1 - f) * a[i] + f * b[i];
    }

  private:
    TorqueRows rows_;
};

// Setpoints are those of the firmware's own code, held through each frame.
class ServoTorque final : public TorqueSource {
  public:
    ServoTorque(const Servo& servo, const Gait& gait, int links)
        : servo_(servo),
          gait_(gait, servo.frame),
          setpoint_(links - 1),
          duty_(links - 1),
          update_(servo.update_hz > 0 ? 1 / servo.update_hz : 0) {}
    double next_jump(double t) const override {
        const double frame = next_start(t, servo_.frame);
        return holds_duty() ? std::min(frame, next_start(t, update_)) : frame;
    }
    void handle_jump(double t, const Chain& k) override {
        gait_.setpoints(index(t, servo_.frame), setpoint_.data(), setpoint_.size());
        // a frame between two updates changes nothing yet
        if (holds_duty() &&
            t >= static_cast<double>(index(t, update_)) * update_ - kGrain * update_ &&
            t <= (static_cast<double>(index(t, update_)) + kGrain) * update_)
            control(k);
    }
    void torques(double, const Chain& k, double* T) override {
        if (!holds_duty()) control(k);
        Supply supply;
        for (std::size_t i = 0; i < duty_.size(); ++i) supply.add(servo_, duty_[i], rate(k, i));
        const double voltage = supply.voltage(servo_.supply_sag);
        for (std::size_t i = 0; i < duty_.size(); ++i) {
            const double w = rate(k, i), dry = servo_.gear_friction * ((w > 0) - (w < 0));
            T[i] = dry - servo_.torque(voltage, duty_[i], w);  // on link i; the head side gets -T
        }
    }

  private:
    static constexpr double kGrain = 1e-9;  // a time within rounding of a start is in it
    static std::uint64_t index(double t, double period) {
        return static_cast<std::uint64_t>(std::floor(t / period + kGrain));
    }
    static double next_start(double t, double period) {
        return (std::floor(t / period + kGrain) + 1) * period;
    }
    static double rate(const Chain& k, std::size_t i) { return k.omega[i + 1] - k.omega[i]; }
    bool holds_duty() const { return update_ > 0; }
    void control(const Chain& k) {
        for (std::size_t i = 0; i < duty_.size(); ++i)
            duty_[i] = servo_.duty(setpoint_[i] - (k.theta[i + 1] - k.theta[i]), rate(k, i));
    }
    Servo servo_;
    FirmwareGait gait_;
    std::vector<double> setpoint_, duty_;
    double update_;  // s; 0: no hold
};

}  // namespace serpenoid
