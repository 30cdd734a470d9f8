// The exact pieces of bench_joint.hpp.
#include "servos/bench_joint.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace serpenoid {

namespace {

constexpr double kTimeRounding = 1e-12;  // s, below any step

struct Motion {
    double angle = 0, rate = 0;

    // Move on for `duration` s under a constant torque, with dry friction against the rate.
    void advance(double duration, double torque, double torque_per_rate, double friction,
                 double inertia) {
        const double decay = torque_per_rate / inertia;
        while (duration > 0) {
            if (rate == 0 && std::abs(torque) <= friction) return;
            const double direction = std::copysign(1.0, rate != 0 ? rate : torque);
            const double final_rate = (torque - friction * direction) / torque_per_rate;
            const bool stops = rate != 0 && final_rate * direction < 0;
            double piece = duration;
            if (stops) piece = std::min(duration, std::log1p(-rate / final_rate) / decay);
            const double approach = -std::expm1(-decay * piece);
            angle += final_rate * piece + (rate - final_rate) * approach / decay;
            rate = stops && piece < duration ? 0 : rate + (final_rate - rate) * approach;
            duration -= piece;
        }
    }
};

}  // namespace

void bench_angles(const BenchJoint& joint, std::span<const double> setpoints,
                  std::span<const double> effect_times, std::span<const double> times,
                  double max_step, std::span<double> angles) {
    const Servo& s = joint.servo;
    // A joint without inertia comes to speed at once: 1e-9 kg m^2 do.
    const double inertia = std::max(s.armature + joint.load_inertia, 1e-9);
    const double motor_line = s.torque_limit / s.speed_limit;
    const bool sampled = s.update_hz > 0;
    double t = times[0];
    double sample_time = t;
    double duty = 0;
    std::size_t next_setpoint = 1;
    std::size_t row = 0;
    Motion motion{joint.start, 0};
    while (row < times.size()) {
        for (; next_setpoint < effect_times.size() &&
               effect_times[next_setpoint] <= t + kTimeRounding;
             ++next_setpoint)
            sample_time = t;
        const bool takes_sample = !sampled || t >= sample_time - kTimeRounding;
        double end = t + max_step;
        if (sampled) {
            if (takes_sample) sample_time += 1 / s.update_hz;
            end = std::min(end, sample_time);
        }
        if (next_setpoint < effect_times.size()) end = std::min(end, effect_times[next_setpoint]);
        const double step = end - t;
        const double middle_angle = motion.angle + 0.5 * step * motion.rate;
        if (takes_sample) {
            const double seen_angle = sampled ? motion.angle : middle_angle;
            duty = s.duty(setpoints[next_setpoint - 1] - seen_angle, motion.rate);
        }
        const bool overrun = duty * motion.rate > duty * duty * s.speed_limit;
        const double supply = overrun ? 1 : 1 / (1 + s.supply_sag * duty * duty);
        double torque = s.torque_limit * duty * supply;
        if (joint.gravity != 0)
            torque -= joint.gravity * std::sin(joint.gain * middle_angle + joint.gravity_angle);
        const double start_angle = motion.angle;
        motion.advance(step, torque, motor_line * supply + s.gear_damping, s.gear_friction,
                       inertia);
        for (; row < times.size() && times[row] <= end; ++row)
            angles[row] = start_angle + (motion.angle - start_angle) * (times[row] - t) / step;
        t = end;
    }
}

}  // namespace serpenoid
