// The joints' setpoints from frame to frame: gaits, poses, gentle changes between them, limits.
//
// A shape is what the joints do at a phase: base_i + alpha sin(phase + i beta); a pose is a shape
// without amplitude. A change blends from one shape to the next while the phase runs on:
//
//     setpoint_i = (1 - s) start_i + s end_i,    s = 3u² - 2u³,  u from 0 to 1 in T seconds
//
// As s stays between 0 and 1, no setpoint leaves the joint limits that both shapes keep; as s
// begins and ends level, speed is continuous. change.h says how long T must be and how fast the
// phase may run meanwhile, so that speed and acceleration keep their bounds too.
#pragma once

#include "change.h"
#include "gait.h"
#include "progmem.h"

namespace firmware {

// How fast things may change and how far joints may go.
struct MotionLimits {
    ChangeLimits change;
    uint16_t frame_us;       // from frame to frame; only at a start
    int16_t servo_step_q14;  // the furthest that any setpoint may move in a frame
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

    // To be filled in place, then told; a setpoint outside is moved inside at once: cut joint
    // limits only while the servos are detached.
    MotionLimits& limits() { return limits_; }
    void limits_changed();

    // Change to this gait. From rest its rate and lag are taken at once. While another change is
    // under way the newest order waits for its end.
    void gait(const Gait& gait);
    // Change to a pose of these angles in Q30 radians.
    void pose(const int32_t (&target_q30)[kMaxJoints]);
    // Hold the setpoints as they are now, from the next frame on.
    void freeze();

    // One frame, or several at once if some were missed: the phase keeps to the clock.
    void advance(uint16_t frames);

    uint16_t frame_us() const { return limits_.frame_us; }
    const int16_t* setpoints_q14() const { return setpoint_q14_; }
    uint32_t phase() const { return static_cast<uint32_t>(phase_ >> 32); }
    // Nothing will move any more without a new order.
    bool arrived() const;
    // How many joints the last frame held back, at a limit or at the servos' speed.
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
    // Growth of the phase in a frame, in 2⁻⁶⁴ turns: now, after the ramp, and of the gait to come.
    uint64_t phase_rate_, target_phase_rate_, next_phase_rate_;
    uint32_t blend_phase_rate_;   // upper bound of it while blending, in 2⁻³² turns
    uint32_t phase_rate_change_;  // of it from frame to frame, in 2⁻³² turns
    GaitShape start_shape_, end_shape_, next_;
    uint32_t progress_q32_, progress_step_q32_;  // u above
    int16_t setpoint_q14_[kMaxJoints];
    uint8_t clipped_;
    bool blending_, waiting_;          // from start_shape_ to end_shape_; next_ waits
    bool gait_, next_gait_, turning_;  // end_shape_ and next_ are gaits; the phase runs
};

}  // namespace firmware
