// The exact pieces of bench_joint.hpp.
#include "servos/bench_joint.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace serpenoid {

namespace {

constexpr double kLeastInertia = 1e-9;   // kg m^2, in place of none: it comes to speed at once
constexpr double kTimeRounding = 1e-12;  // s, below any step

struct Motion {
    double angle = 0, rate = 0;
};

// Move on for `h` s under a constant torque, with the dry friction that acts against the rate.
void move(Motion& m, double h, double torque, double brake, double friction, double inertia) {
    const double fall = brake / inertia;
    while (h > 0) {
        if (m.rate == 0 && std::abs(torque) <= friction) return;
        const double way = m.rate != 0 ? std::copysign(1.0, m.rate) : std::copysign(1.0, torque);
        const double last = (torque - friction * way) / brake;  // rate after a long time
        double part = h;
        const bool stops = m.rate != 0 && last * way < 0;
        if (stops) part = std::min(h, std::log1p(-m.rate / last) / fall);
        const double share = -std::expm1(-fall * part);
        m.angle += last * part + (m.rate - last) * share / fall;
        m.rate = stops && part < h ? 0 : m.rate + (last - m.rate) * share;
        h -= part;
    }
}

}  // namespace

void bench_angles(const BenchJoint& joint, std::span<const double> setpoints,
                  std::span<const double> heard, std::span<const double> times, double longest,
                  std::span<double> angles) {
    const Servo& s = joint.servo;
    const double inertia = std::max(s.armature + joint.load_inertia, kLeastInertia);
    const double line = s.torque_limit / s.speed_limit;
    const double between = s.update_hz > 0 ? 1 / s.update_hz : 0;
    double t = times[0], look = t + joint.first_look, duty = 0;
    std::size_t next = 1, row = 0;
    Motion m{joint.start, 0};
    while (row < times.size()) {
        while (next < heard.size() && heard[next] <= t + kTimeRounding) ++next;
        double end = t + longest;
        bool looks = !between;
        if (between && t >= look - kTimeRounding) looks = true, look += between;
        if (between)
            end = std::min(end, look);
        else if (next < heard.size())
            end = std::min(end, heard[next]);
        const double h = end - t;
        if (looks) {
            const double ahead = between ? 0 : 0.5 * h * m.rate;
            double goal = setpoints[next - 1];
            if (joint.blend > 0 && next > 1) {
                const double share = std::min(1.0, (t - heard[next - 1]) * s.update_hz);
                goal = share * goal + (1 - share) * setpoints[next - 2];
            }
            duty = s.duty(goal - m.angle - ahead, m.rate);
        }
        const bool overrun = duty * m.rate > duty * duty * s.speed_limit;
        const double sag = overrun ? 1 : 1 / (1 + s.supply_sag * duty * duty);
        double torque = s.torque_limit * duty * sag;
        if (joint.gravity != 0)
            torque -= joint.gravity *
                      std::sin(joint.gain * (m.angle + 0.5 * h * m.rate) + joint.gravity_angle);
        const double before = m.angle;
        move(m, h, torque, line * sag + s.gear_damping, s.gear_friction, inertia);
        for (; row < times.size() && times[row] <= end; ++row)
            angles[row] = before + (m.angle - before) * (times[row] - t) / h;
        t = end;
    }
}

}  // namespace serpenoid
