// How long a change of shape takes, and how fast the phase may run meanwhile.
#pragma once

#include <stdint.h>

namespace firmware {

// What the owner allows, in radians and seconds.
struct ChangeLimits {
    float swing_rad_s;  // `angle_ramp`: how fast amplitude and lag may move a joint
    float rate_rad_s2;  // `rate_ramp`: how fast the rate may change
    float pose_rad_s;   // `pose_speed`: how fast bases may move
    float servo_rad_s;  // `servo_speed`: how fast any joint may move
};

// Two shapes and their rates, as far as a change depends on them; what is at rest has rate 0.
struct ChangeRequest {
    float alpha_1_rad, alpha_2_rad;
    float omega_1_rad_s, omega_2_rad_s;
    float swing_rad;  // the largest difference of the oscillating parts, at the same phase
    float shift_rad;  // the largest difference of the bases
};

struct ChangePlan {
    float duration_s;         // of the blend
    float omega_rad_s;        // the fastest rate while blending
    float omega_rate_rad_s2;  // how fast the rate may change before and after
};

ChangePlan plan_change(const ChangeRequest& request, const ChangeLimits& limits);

}  // namespace firmware
