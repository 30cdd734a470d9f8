// The setpoints of the joints in every frame: gaits, poses, smooth changes between them, limits.
//
// A shape gives the joint angles at a phase: base_i + alpha sin(phase + i beta). A pose is a shape
// with alpha = 0. A change blends one shape into the next while the phase continues:
//
//     setpoint_i = (1 - s) start_i + s end_i,    s = 3u² - 2u³,  u from 0 to 1 in T seconds
//
// s stays between 0 and 1, so every setpoint keeps the joint limits if both shapes do. ds/du is 0
// at both ends, so the speed is continuous. change.h computes T and the greatest rate of the phase
// during a change, so that speed and acceleration keep their limits too.
#pragma once

#include "change.h"
#include "gait.h"
#include "progmem.h"

namespace firmware {

// Limits of changes, of the motion within a frame, and of the joint angles.
struct MotionLimits {
    ChangeLimits change;
    uint16_t frame_us;       // time between frames; may be set only at a start
    int16_t servo_step_q14;  // greatest change of a setpoint in a frame
    int16_t low_q14[kMaxJoints];
    int16_t high_q14[kMaxJoints];
};

struct GaitShape {
    int16_t alpha_q14;
    int32_t beta_q31_turn;
    int16_t base_q14[kMaxJoints];
};

class Motion {
  public:
    Motion();

    // Change the limits in place, then call limits_changed. It moves setpoints that are outside to
    // the limit at once, so narrow the limits only while the servos are detached.
    MotionLimits& limits() { return limits_; }
    void limits_changed();

    // Change to this gait. From rest its omega and beta apply at once. If a change is under way,
    // this one follows it, instead of any other that waits.
    void gait(const Gait& gait);
    // Change to a pose of these angles in Q30 radians.
    void pose(const int32_t (&target_q30)[kMaxJoints]);
    // Hold the present setpoints from the next frame on.
    void freeze();

    // Advance by one frame, or by several if frames were missed, so that the phase follows the
    // clock.
    void advance(uint16_t frames);

    uint16_t frame_us() const { return limits_.frame_us; }
    const int16_t* setpoints_q14() const { return setpoint_q14_; }
    uint32_t phase() const { return static_cast<uint32_t>(phase_ >> 32); }
    // Whether nothing moves until the next order.
    bool arrived() const;
    // The number of joints whose setpoint the last frame limited, in angle or speed.
    uint8_t clipped() const { return clipped_; }

  private:
    void order(uint64_t phase_rate, bool gait);
    bool under_way() const { return blending_ && progress_q32_ != 0; }
    OWN_FRAME void begin();
    void proceed();
    bool approach(uint32_t rate);
    int16_t angle_of(const GaitShape& shape, uint8_t joint) const;
    int16_t limited(uint8_t joint, int32_t target_q14);

    MotionLimits limits_;
    uint64_t phase_;  // in 2⁻⁶⁴ turns
    // Change of the phase in a frame, in 2⁻⁶⁴ turns: at present, after the ramp, of the next gait.
    uint64_t phase_rate_, target_phase_rate_, next_phase_rate_;
    uint32_t blend_phase_rate_;   // upper bound of phase_rate_ while blending, in 2⁻³² turns
    uint32_t phase_rate_change_;  // change of phase_rate_ in a frame, in 2⁻³² turns
    GaitShape start_shape_, end_shape_, next_;
    uint32_t progress_q32_, progress_step_q32_;  // u above
    int16_t setpoint_q14_[kMaxJoints];
    uint8_t clipped_;
    bool blending_, waiting_;  // a change from start_shape_ to end_shape_ runs; next_ waits for it
    bool gait_, next_gait_, turning_;  // end_shape_ is a gait, next_ is a gait; the phase advances
};

}  // namespace firmware
