// Setpoints of motion.h. A frame uses integers only; the plan of a change, once an order, uses
// floats.
#include "motion.h"

#include <string.h>

namespace firmware {
namespace {

const float kRadPerQ14 = 1.0F / 16384;
const float kRadPerQ32Turn = 6.2831853F / 4294967296.0F;
// Rounding errors of a setpoint that are accepted in steps and at limits, Q14 radians (0.01°).
const int16_t kRoundingQ14 = 3;

float magnitude(float x) { return x < 0 ? -x : x; }

uint32_t upper(uint64_t step) { return static_cast<uint32_t>(step >> 32); }

float rate_of(uint64_t step, float frame_s) {
    return static_cast<float>(upper(step)) * (kRadPerQ32Turn / frame_s);
}

uint32_t step_of(float omega_rad_s, float frame_s) {
    return static_cast<uint32_t>(omega_rad_s * (frame_s / kRadPerQ32Turn)) | 1U;
}

// Upper bound, rad, of the difference of two shapes without their bases, at any phase, of any
// joint.
float swing_between(const GaitShape& a, const GaitShape& b) {
    const uint32_t lag_q31 =
        static_cast<uint32_t>(b.beta_q31_turn) - static_cast<uint32_t>(a.beta_q31_turn);
    const uint32_t lag = lag_q31 << 1;
    const float lag_rad = magnitude(static_cast<float>(static_cast<int32_t>(lag))) * kRadPerQ32Turn;
    const float chord = lag_rad * (joint_count - 1);
    const int16_t smaller_alpha_q14 = a.alpha_q14 < b.alpha_q14 ? a.alpha_q14 : b.alpha_q14;
    return (magnitude(static_cast<float>(b.alpha_q14 - a.alpha_q14)) +
            static_cast<float>(smaller_alpha_q14) * (chord < 2 ? chord : 2)) *
           kRadPerQ14;
}

float shift_between(const GaitShape& a, const GaitShape& b) {
    float largest = 0;
    for (uint8_t i = 0; i < joint_count; ++i) {
        const int32_t shift = static_cast<int32_t>(b.base_q14[i]) - a.base_q14[i];
        const float size = magnitude(static_cast<float>(shift));
        if (size > largest) largest = size;
    }
    return largest * kRadPerQ14;
}

bool equal(const GaitShape& a, const GaitShape& b) {
    return swing_between(a, b) == 0 && shift_between(a, b) == 0;
}

// 3u² - 2u³ in Q14, of u in Q16.
int32_t smooth_q14(uint16_t u) {
    const uint32_t square = (static_cast<uint32_t>(u) * u) >> 16;
    return static_cast<int32_t>((square * ((196608UL - 2UL * u) >> 2)) >> 16);
}

}  // namespace

// All members are numbers. On an AVR one loop takes less flash than an instruction for each.
Motion::Motion() {
    memset(static_cast<void*>(this), 0, sizeof *this);  // cppcheck-suppress memsetClassFloat
    limits_.frame_us = kFrameUs;
}

void Motion::limits_changed() {
    for (uint8_t i = 0; i < joint_count; ++i) {
        if (setpoint_q14_[i] < limits_.low_q14[i]) setpoint_q14_[i] = limits_.low_q14[i];
        if (setpoint_q14_[i] > limits_.high_q14[i]) setpoint_q14_[i] = limits_.high_q14[i];
    }
}

void Motion::gait(const Gait& gait) {
    next_.alpha_q14 = q14_from_q30(q30_from_udeg(gait.alpha_udeg));
    next_.beta_q31_turn = q31_turn_from_udeg(gait.beta_udeg);
    for (int16_t& base : next_.base_q14) base = q14_from_q30(q30_from_udeg(gait.offset_udeg));
    order(phase_step(gait.omega_urad_s, frame_us()), true);
}

void Motion::pose(const int32_t (&target_q30)[kMaxJoints]) {
    next_.alpha_q14 = 0;
    next_.beta_q31_turn = end_shape_.beta_q31_turn;
    for (uint8_t i = 0; i < joint_count; ++i) next_.base_q14[i] = q14_from_q30(target_q30[i]);
    order(phase_rate_, false);
}

void Motion::freeze() {
    for (uint8_t i = 0; i < joint_count; ++i) start_shape_.base_q14[i] = setpoint_q14_[i];
    start_shape_.alpha_q14 = 0;
    end_shape_ = start_shape_;
    blending_ = waiting_ = gait_ = turning_ = false;
}

void Motion::order(uint64_t phase_rate, bool gait) {
    next_phase_rate_ = phase_rate;
    next_gait_ = gait;
    waiting_ = true;
    if (under_way() && gait == gait_ &&
        equal(next_, end_shape_)) {  // the present change leads to it
        target_phase_rate_ = phase_rate;
        waiting_ = false;
    }
}

// Plan the change from the current shape to next_.
void Motion::begin() {
    const float frame_s = frame_us() * 1e-6F;
    end_shape_ = next_;
    gait_ = next_gait_;
    waiting_ = false;
    if (!turning_) start_shape_.beta_q31_turn = end_shape_.beta_q31_turn;
    ChangeRequest request;
    request.alpha_1_rad = start_shape_.alpha_q14 * kRadPerQ14;
    request.alpha_2_rad = end_shape_.alpha_q14 * kRadPerQ14;
    request.omega_1_rad_s = turning_ ? rate_of(phase_rate_, frame_s) : 0;
    request.omega_2_rad_s = gait_ ? rate_of(next_phase_rate_, frame_s) : 0;
    request.swing_rad = swing_between(start_shape_, end_shape_);
    request.shift_rad = shift_between(start_shape_, end_shape_);
    const ChangePlan plan = plan_change(request, limits_.change);
    blend_phase_rate_ = step_of(plan.omega_rad_s, frame_s);
    target_phase_rate_ = gait_ ? next_phase_rate_ : static_cast<uint64_t>(blend_phase_rate_) << 32;
    if (blend_phase_rate_ > upper(target_phase_rate_))
        blend_phase_rate_ = upper(target_phase_rate_);
    if (!turning_) phase_rate_ = static_cast<uint64_t>(blend_phase_rate_) << 32;
    phase_rate_change_ = step_of(plan.omega_rate_rad_s2 * frame_s, frame_s);
    turning_ = turning_ || gait_;
    blending_ = request.swing_rad + request.shift_rad > 0;
    const float frames = plan.duration_s / frame_s + 1;
    progress_q32_ = 0;
    progress_step_q32_ = static_cast<uint32_t>(4294967040.0F / frames);
    if (!blending_) start_shape_ = end_shape_;
}

// Change the phase rate towards this one by one frame; true if it is reached, to 2⁻³² turns.
bool Motion::approach(uint32_t rate) {
    const uint32_t current_rate = upper(phase_rate_);
    const uint32_t gap = current_rate < rate ? rate - current_rate : current_rate - rate;
    if (gap <= phase_rate_change_) return true;
    phase_rate_ = static_cast<uint64_t>(current_rate < rate ? current_rate + phase_rate_change_
                                                            : current_rate - phase_rate_change_)
                  << 32;
    return false;
}

// Advance by one frame: reduce the phase rate if it is too high, then blend, then set the rate.
void Motion::proceed() {
    if (!blending_) {
        if (approach(upper(target_phase_rate_))) phase_rate_ = target_phase_rate_;
    } else if (turning_ && upper(phase_rate_) > blend_phase_rate_) {
        if (approach(blend_phase_rate_))
            phase_rate_ = static_cast<uint64_t>(blend_phase_rate_) << 32;
    } else {
        const uint32_t previous_progress_q32 = progress_q32_;
        progress_q32_ += progress_step_q32_;
        if (progress_q32_ < previous_progress_q32) {
            start_shape_ = end_shape_;
            blending_ = false;
        }
    }
    if (!blending_) turning_ = turning_ && gait_;
}

int16_t Motion::angle_of(const GaitShape& shape, uint8_t joint) const {
    const int16_t swing = gait_angle(shape.alpha_q14, shape.beta_q31_turn, phase(), joint);
    return static_cast<int16_t>(shape.base_q14[joint] + swing);
}

// The angle closest to the target within the limits of angle and speed.
int16_t Motion::limited(uint8_t joint, int32_t target_q14) {
    const int32_t low = limits_.low_q14[joint], high = limits_.high_q14[joint];
    const int32_t step = limits_.servo_step_q14 + kRoundingQ14;
    const int32_t lowest = setpoint_q14_[joint] - step, highest = setpoint_q14_[joint] + step;
    int32_t angle = target_q14 < low ? low : target_q14 > high ? high : target_q14;
    angle = angle < lowest ? lowest : angle > highest ? highest : angle;
    const int32_t excess_q14 = angle - target_q14;
    if (excess_q14 > kRoundingQ14 || excess_q14 < -kRoundingQ14) ++clipped_;
    return static_cast<int16_t>(angle);
}

void Motion::advance(uint16_t frames) {
    if (waiting_ && !under_way()) begin();
    if (turning_) phase_ += phase_rate_ * frames;
    proceed();
    clipped_ = 0;
    const int32_t weight_q14 = smooth_q14(static_cast<uint16_t>(progress_q32_ >> 16));
    for (uint8_t i = 0; i < joint_count; ++i) {
        int32_t target_q14 = angle_of(start_shape_, i);
        if (blending_) {
            // The difference is at most 4 rad, which is 2¹⁶; times 2¹⁴ it fits into 32 bits.
            const int32_t difference_q14 = angle_of(end_shape_, i) - target_q14;
            target_q14 += (difference_q14 * weight_q14 + 0x2000) >> 14;
        }
        setpoint_q14_[i] = limited(i, target_q14);
    }
}

bool Motion::arrived() const {
    if (turning_ || blending_ || waiting_) return false;
    for (uint8_t i = 0; i < joint_count; ++i) {
        if (setpoint_q14_[i] != start_shape_.base_q14[i]) return false;
    }
    return true;
}

}  // namespace firmware
