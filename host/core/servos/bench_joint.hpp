// One joint of a servo on a bench: its angle while it is sent a history of setpoints.
//
// The duty is constant between two samples of the loop, or within a step of a continuous loop. The
// motor's line, the sagging supply and the gear's damping are then linear in the rate,
//     J phi'' = S d / (1 + sag d^2) - (S / w0 / (1 + sag d^2) + c) phi' - F sgn phi' - G,
// (no sag in a motor that is driven faster than its duty), which is solved exactly from one stop of
// the joint to the next; gravity's torque G is that of the step's middle.
//
// A sampled loop takes a sample when a setpoint takes effect, and from there on at its own rate. So
// the angles depend smoothly on the times at which setpoints take effect. A real loop samples at a
// rate of its own and acts on a setpoint at the next sample: its motion is this one, with those
// times.
#pragma once

#include <span>

#include "drive/servo.hpp"

namespace serpenoid {

struct BenchJoint {
    Servo servo;               // of it the frame is not used
    double load_inertia = 0;   // kg m^2, on top of the rotor's
    double gravity = 0;        // N m: the torque is -gravity sin(gain phi + direction)
    double gravity_angle = 0;  // rad, the direction above
    double gain = 1;           // of the load's angle over the servo's own
    double start = 0;          // rad, angle at the first time of the table; at rest there
};

// Angles (rad) at rising `times` (s). Setpoint k takes effect at `effect_times[k]`, rising; the
// first one from the beginning on. Steps of at most `max_step` s.
void bench_angles(const BenchJoint& joint, std::span<const double> setpoints,
                  std::span<const double> effect_times, std::span<const double> times,
                  double max_step, std::span<double> angles);

}  // namespace serpenoid
