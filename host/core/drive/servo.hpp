// A hobby servo: a position loop, a motor on a supply that sags, and a gear.
//
// The duty d is what the loop asks of the supply, at most all of it either way:
//     d = clamp((K e - D phi') / S + phi' / w0, -1, 1),
// with e the error to the setpoint beyond the dead band, S the stalled torque and w0 the free
// speed. The motor's line gives the torque at the gear's output,
//     tau = S (V d - phi' / w0) - c phi' - F sgn phi',    J phi'' on top as inertia,
// so that inside the limits the loop is the spring K and the damper D that it is stated as. V is
// the supply, as a share of its voltage without load: with i = d (V d - phi'/w0) the current that a
// servo draws, over that of one that is stalled, V = 1 - sag * sum i.
#pragma once

#include <algorithm>
#include <cmath>

namespace serpenoid {

struct Servo {
    double stiffness = 0;      // K, N m/rad
    double damping = 0;        // D, N m s/rad: the loop's and the motor's own
    double torque_limit = 0;   // S, N m
    double speed_limit = 0;    // w0, rad/s
    double dead_band = 0;      // rad, error below which the loop asks for nothing
    double armature = 0;       // J, kg m^2: the rotor's inertia times the gear ratio squared
    double gear_friction = 0;  // F, N m
    double gear_damping = 0;   // c, N m s/rad
    double update_hz = 0;      // of the loop, which holds its duty in between; 0: continuous
    double supply_sag = 0;     // of the voltage, by one stalled servo
    double frame = 0.02;       // s, between two setpoints

    double beyond(double error) const { return error - std::clamp(error, -dead_band, dead_band); }
    double duty(double error, double rate) const {
        const double loop_duty = (stiffness * beyond(error) - damping * rate) / torque_limit;
        return std::clamp(loop_duty + rate / speed_limit, -1.0, 1.0);
    }
    // All but the gear's dry friction.
    double torque(double supply, double duty, double rate) const {
        return torque_limit * (supply * duty - rate / speed_limit) - gear_damping * rate;
    }
};

// The fields under the names that Python has for them.
template <class Visit>
void each_servo_field(const Visit& field) {
    field("stiffness_nm_rad", &Servo::stiffness);
    field("damping_nms_rad", &Servo::damping);
    field("torque_limit_nm", &Servo::torque_limit);
    field("speed_limit_rad_s", &Servo::speed_limit);
    field("dead_band_rad", &Servo::dead_band);
    field("armature_kg_m2", &Servo::armature);
    field("gear_friction_nm", &Servo::gear_friction);
    field("gear_damping_nms_rad", &Servo::gear_damping);
    field("update_hz", &Servo::update_hz);
    field("supply_sag", &Servo::supply_sag);
    field("frame_s", &Servo::frame);
}

// The supply under all servos' load, by their duties and rates.
class Supply {
  public:
    void add(const Servo& s, double duty, double rate) {
        squares_ += duty * duty;
        back_emf_ += duty * rate / s.speed_limit;
    }
    double voltage(double sag) const {
        return std::clamp((1 + sag * back_emf_) / (1 + sag * squares_), 0.0, 1.0);
    }

  private:
    double squares_ = 0, back_emf_ = 0;
};

}  // namespace serpenoid
