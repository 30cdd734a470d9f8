// The gait formula in fixed point: phi_i = offset + alpha sin(phase + i beta), one value per frame
// of 20 ms or as long as the board's owner sets.
//
// Units: joint angles in Q14 radians (16384 is 1 rad, ±2 rad), ramped quantities in Q30 radians,
// the phase as a 64-bit fraction of a turn that wraps by itself, of which the upper 32 bits are
// used. Joints count from 0 here, from 1 in prose. On the wire everything is in millionths (`_u`).
#pragma once

#include <stdint.h>

namespace firmware {

// How many joints the robot has: one build flag, which all else follows. The host builds the
// firmware once, with SERPENOID_ANY_JOINTS, for virtual boards of 2 to 12 joints.
#ifndef SERPENOID_JOINTS
#define SERPENOID_JOINTS 5
#endif
static_assert(SERPENOID_JOINTS >= 2 && SERPENOID_JOINTS <= 12,
              "SERPENOID_JOINTS must be 2 to 12, as the protocol has it");
#ifdef SERPENOID_ANY_JOINTS
const uint8_t kMaxJoints = 12;
extern thread_local uint8_t joint_count;  // of the board that runs
#else
const uint8_t kMaxJoints = SERPENOID_JOINTS, joint_count = SERPENOID_JOINTS;
#endif

// From frame to frame, as long as nobody asks for another time and the board can keep it.
const uint16_t kFrameUs = 20000;

// A quantity per second, in millionths, as a quantity per frame.
inline int32_t per_frame_u(int32_t value_u, uint16_t frame_us) {
    return value_u / 10000 * (frame_us / 10) / 10;
}

// What a `gait` command asks for, in the wire's units.
struct Gait {
    int32_t alpha_udeg;    // amplitude
    int32_t beta_udeg;     // lag from joint to joint
    int32_t omega_urad_s;  // rate
    int32_t offset_udeg;   // steering
};

// Millionths of a degree to Q30 radians. Exact to half a unit for |angle| <= 114.59 degrees (2
// rad).
int32_t q30_from_udeg(int32_t angle_udeg);

// Millionths of a degree to Q31 turns (2³¹ is a whole turn), for lags of up to half a turn.
int32_t q31_turn_from_udeg(int32_t angle_udeg);

// Hundredths of a degree, rounded, of a joint angle in Q14 radians.
int16_t cdeg_from_q14(int16_t angle_q14);

// Thousandths of a degree, 0 to 359999, of a phase in 2⁻³² turns.
uint32_t mdeg_from_phase(uint32_t phase);

// Phase per frame in 2⁻⁶⁴ turns, for 0 <= rate <= 50 rad/s; relative error below 1e-10 of
// 2⁶⁴ · frame / 2π, at 20 ms 1e-11.
uint64_t phase_step(int32_t omega_urad_s, uint16_t frame_us = kFrameUs);

inline int16_t q14_from_q30(int32_t angle_q30) {
    return static_cast<int16_t>((angle_q30 + 0x8000L) >> 16);
}

// The oscillating part of one joint: alpha sin(phase + joint · beta), rounded to Q14.
int16_t gait_angle(int16_t alpha_q14, int32_t beta_q31_turn, uint32_t phase, uint8_t joint);

}  // namespace firmware
