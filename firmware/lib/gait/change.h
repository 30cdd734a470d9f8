// The duration of a change of shape, and the limit of the phase rate during it.
#pragma once

#include <stdint.h>

namespace firmware {

// Limits set by the owner, in radians and seconds.
struct ChangeLimits {
    float swing_rad_s;  // `angle_ramp`: speed of a joint by changes of amplitude and lag
    float rate_rad_s2;  // `rate_ramp`: change of omega in a second
    float pose_rad_s;   // `pose_speed`: speed of the bases
    float servo_rad_s;  // `servo_speed`: speed of any joint
};

// The properties of two shapes on which a change depends. A pose has omega 0.
struct ChangeRequest {
    float alpha_1_rad, alpha_2_rad;
    float omega_1_rad_s, omega_2_rad_s;
    float swing_rad;  // greatest difference of the oscillating parts, at the same phase
    float shift_rad;  // greatest difference of the bases
};

struct ChangePlan {
    float duration_s;         // duration of the blend
    float omega_rad_s;        // greatest omega while blending
    float omega_rate_rad_s2;  // change of omega in a second, before and after the blend
};

ChangePlan plan_change(const ChangeRequest& request, const ChangeLimits& limits);

}  // namespace firmware
