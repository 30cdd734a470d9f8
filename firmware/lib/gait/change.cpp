// The bounds. With D = swing + shift, V = swing · rate and a smooth s of duration T, which has
// |s'| <= 1.5/T and |s''| <= 6/T², a blend at constant rate moves each joint
//     no faster than     A rate + 1.5 D / T                     (A: the larger amplitude)
//     and accelerates it no more than   A rate² + 3 V / T + 6 D / T².
// T is the least that keeps the speed below servo_speed and the acceleration below twice that of
// the stronger gait. Changes of the rate come before the blend (downwards) or behind it (upwards),
// and add A · omega_rate to the acceleration of one gait alone.
#include "change.h"

#include <math.h>

namespace firmware {
namespace {

const float kDegree = 0.017453293F;
// Below these accelerations nothing is gained by going slower.
const float kGentleGaitRadS2 = 20 * kDegree;
const float kGentlePoseRadS2 = 400 * kDegree;
// What blending leaves of servo_speed to the gaits, and what roundings leave of it to both.
const float kGaitsShare = 0.75F;
const float kUsable = 0.98F;

float larger(float a, float b) { return a > b ? a : b; }
float smaller(float a, float b) { return a < b ? a : b; }

}  // namespace

ChangePlan plan_change(const ChangeRequest& r, const ChangeLimits& limits) {
    const float alpha = larger(r.alpha_1_rad, r.alpha_2_rad);
    float omega = r.omega_1_rad_s == 0   ? r.omega_2_rad_s
                  : r.omega_2_rad_s == 0 ? r.omega_1_rad_s
                                         : smaller(r.omega_1_rad_s, r.omega_2_rad_s);
    const float distance = r.swing_rad + r.shift_rad;
    if (distance > 0 && alpha * omega > kGaitsShare * limits.servo_rad_s) {
        omega = kGaitsShare * limits.servo_rad_s / alpha;
    }
    const float strongest = larger(alpha > 0 ? kGentleGaitRadS2 : kGentlePoseRadS2,
                                   larger(r.alpha_1_rad * r.omega_1_rad_s * r.omega_1_rad_s,
                                          r.alpha_2_rad * r.omega_2_rad_s * r.omega_2_rad_s));
    const float spare = 2 * strongest - alpha * omega * omega;
    const float turn = 3 * r.swing_rad * omega;
    float duration_s = (turn + sqrtf(turn * turn + 24 * distance * spare)) / (2 * spare);
    duration_s = larger(duration_s, 1.5F * r.swing_rad / limits.swing_rad_s);
    duration_s = larger(duration_s, 1.5F * r.shift_rad / limits.pose_rad_s);
    duration_s =
        larger(duration_s, 1.5F * distance / (kUsable * limits.servo_rad_s - alpha * omega));
    const float rate =
        alpha > 0 ? smaller(limits.rate_rad_s2, strongest / alpha) : limits.rate_rad_s2;
    return ChangePlan{duration_s, omega, rate};
}

}  // namespace firmware
