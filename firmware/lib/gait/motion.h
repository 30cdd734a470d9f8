// The five setpoints from frame to frame: gait, pose, ramps between them, joint limits, speed
// limit.
//
// setpoint_i = limits(base_i + alpha sin(phase + i beta)). A pose moves the bases, a gait moves the
// bases to the steering offset and alpha up from where it is. So every change is continuous in
// position; the speed limit at the end of the chain holds what overlapping changes may add up to.
#pragma once

#include "gait.h"

namespace firmware {

// How fast things may change and how far joints may go, in the units of gait.h, per frame.
struct MotionLimits {
    int32_t angle_step_q30;      // amplitude
    int32_t beta_step_q31_turn;  // lag
    uint64_t rate_step;          // change of the phase step
    int32_t pose_step_q30;       // poses and steering
    int16_t servo_step_q14;      // any setpoint, whatever asks for it
    int16_t low_q14[kJoints];
    int16_t high_q14[kJoints];
};

class Motion {
  public:
    Motion();

    // New ramps and limits. A setpoint outside is moved inside at once: cut joint limits only while
    // the servos are detached.
    void limit(const MotionLimits& limits);

    // Ramp to this gait. From rest the rate and the lag are taken at once: the amplitude is still
    // 0.
    void gait(const Gait& gait);
    // Move each joint to an angle in Q30 radians; a running gait fades out meanwhile.
    void pose(const int32_t (&target_q30)[kJoints]);
    // Hold the setpoints as they are now, from the next frame on.
    void freeze();

    // One frame, or several at once if some were missed: the phase keeps to the clock.
    void advance(uint16_t frames);

    const int16_t* setpoints_q14() const { return setpoint_q14_; }
    uint32_t phase() const { return static_cast<uint32_t>(phase_ >> 32); }
    // Nothing will move any more without a new order.
    bool arrived() const;
    // The last frame had to hold a joint back at a limit.
    bool limited() const { return limited_; }

  private:
    void ramp();
    int16_t held(uint8_t joint, int32_t wanted_q14);

    MotionLimits limits_;
    uint64_t phase_, step_, step_target_;
    int32_t alpha_q30_, alpha_target_q30_;
    int32_t beta_q31_turn_, beta_target_q31_turn_;
    int32_t base_q30_[kJoints], base_target_q30_[kJoints];
    int16_t setpoint_q14_[kJoints];
    bool gait_, turning_, limited_;  // a gait is wanted; the phase runs (also while one fades)
};

}  // namespace firmware
