// Ramps and limits are in integers; nothing here divides or allocates.
#include "motion.h"

namespace firmware {
namespace {

// The distance is taken unsigned: it may be the whole range of the type.
int32_t approach(int32_t now, int32_t target, int32_t step) {
    const uint32_t a = static_cast<uint32_t>(now), b = static_cast<uint32_t>(target);
    const uint32_t reach = static_cast<uint32_t>(step);
    if (now < target) return b - a > reach ? now + step : target;
    return a - b > reach ? now - step : target;
}

uint64_t approach(uint64_t now, uint64_t target, uint64_t step) {
    if (now < target) return target - now > step ? now + step : target;
    return now - target > step ? now - step : target;
}

}  // namespace

Motion::Motion()
    : limits_(),
      phase_(0),
      step_(0),
      step_target_(0),
      alpha_q30_(0),
      alpha_target_q30_(0),
      beta_q31_turn_(0),
      beta_target_q31_turn_(0),
      base_q30_(),
      base_target_q30_(),
      setpoint_q14_(),
      gait_(false),
      turning_(false),
      limited_(false) {}

void Motion::limit(const MotionLimits& limits) {
    limits_ = limits;
    for (uint8_t i = 0; i < kJoints; ++i) {
        if (setpoint_q14_[i] < limits.low_q14[i]) setpoint_q14_[i] = limits.low_q14[i];
        if (setpoint_q14_[i] > limits.high_q14[i]) setpoint_q14_[i] = limits.high_q14[i];
    }
}

void Motion::gait(const Gait& gait) {
    alpha_target_q30_ = q30_from_udeg(gait.alpha_udeg);
    beta_target_q31_turn_ = q31_turn_from_udeg(gait.beta_udeg);
    step_target_ = phase_step(gait.omega_urad_s);
    for (int32_t& base : base_target_q30_) base = q30_from_udeg(gait.offset_udeg);
    if (!turning_) {
        beta_q31_turn_ = beta_target_q31_turn_;
        step_ = step_target_;
    }
    gait_ = turning_ = true;
}

void Motion::pose(const int32_t (&target_q30)[kJoints]) {
    for (uint8_t i = 0; i < kJoints; ++i) base_target_q30_[i] = target_q30[i];
    alpha_target_q30_ = 0;
    gait_ = false;
}

void Motion::freeze() {
    for (uint8_t i = 0; i < kJoints; ++i) {
        base_target_q30_[i] = base_q30_[i] = static_cast<int32_t>(setpoint_q14_[i]) * 65536L;
    }
    alpha_target_q30_ = alpha_q30_ = 0;
    gait_ = turning_ = false;
}

void Motion::ramp() {
    alpha_q30_ = approach(alpha_q30_, alpha_target_q30_, limits_.angle_step_q30);
    beta_q31_turn_ = approach(beta_q31_turn_, beta_target_q31_turn_, limits_.beta_step_q31_turn);
    step_ = approach(step_, step_target_, limits_.rate_step);
    for (uint8_t i = 0; i < kJoints; ++i) {
        base_q30_[i] = approach(base_q30_[i], base_target_q30_[i], limits_.pose_step_q30);
    }
    if (!gait_ && alpha_q30_ == 0) turning_ = false;
}

// The angle nearest to the one wanted that limits and speed allow.
int16_t Motion::held(uint8_t joint, int32_t wanted_q14) {
    int32_t low = limits_.low_q14[joint], high = limits_.high_q14[joint];
    const int32_t slowest = static_cast<int32_t>(setpoint_q14_[joint]) - limits_.servo_step_q14;
    const int32_t fastest = static_cast<int32_t>(setpoint_q14_[joint]) + limits_.servo_step_q14;
    int32_t angle = wanted_q14 < low ? low : wanted_q14 > high ? high : wanted_q14;
    angle = angle < slowest ? slowest : angle > fastest ? fastest : angle;
    if (angle != wanted_q14) limited_ = true;
    return static_cast<int16_t>(angle);
}

void Motion::advance(uint16_t frames) {
    if (turning_) phase_ += step_ * frames;
    ramp();
    limited_ = false;
    const int16_t alpha_q14 = q14_from_q30(alpha_q30_);
    for (uint8_t i = 0; i < kJoints; ++i) {
        const int16_t swing = gait_angle(alpha_q14, beta_q31_turn_, phase(), i);
        setpoint_q14_[i] = held(i, static_cast<int32_t>(q14_from_q30(base_q30_[i])) + swing);
    }
}

bool Motion::arrived() const {
    if (gait_ || turning_) return false;
    for (uint8_t i = 0; i < kJoints; ++i) {
        if (base_q30_[i] != base_target_q30_[i]) return false;
        if (setpoint_q14_[i] != q14_from_q30(base_q30_[i])) return false;
    }
    return true;
}

}  // namespace firmware
