// Servos at the board's own pins. The refresh of the Servo library (one pulse for each servo, one
// after the other, and then a gap) is synchronised with the frames.
#ifndef SERPENOID_PCA9685
#include <Arduino.h>
#include <Servo.h>

#include "board.h"
#include "servo_driver.h"
#include "servo_timer.h"
#include "settings.h"

namespace servo_driver {
namespace {

// Delay from the time at which a frame is due to its first pulse. In this time the pulses are
// computed, even if the frame begins late.
const uint16_t kPulseDelayUs = 3000;
// Shortest remaining gap in which pulses are written, which takes 60 µs and interrupts 40 µs more.
const uint16_t kMinGapUs = 150;

Servo servos[firmware::kMaxJoints];
int16_t pending_pulse_us[firmware::kMaxJoints];
uint32_t frame_due_us;  // time at which the frame of pending_pulse_us is due
uint16_t frame_length_us;
bool pulses_pending;  // pending_pulse_us is not yet written to the library
bool detach_pending;

// Detach all servos whose pins are low. The Servo library would leave a pin high if its servo were
// detached during a pulse; these servos remain for the next call.
void detach_between_pulses() {
    detach_pending = false;
    for (uint8_t i = 0; i < firmware::joint_count; ++i) {
        if (!servos[i].attached()) continue;
        noInterrupts();
        const bool low = digitalRead(board::servo_pin(i)) == LOW;
        if (low) servos[i].detach();
        interrupts();
        if (!low) detach_pending = true;
    }
}

void write_pulses() {
    pulses_pending = false;
    for (uint8_t i = 0; i < firmware::joint_count; ++i) {
        if (pending_pulse_us[i] != 0)
            servos[i].writeMicroseconds(pending_pulse_us[i] - board::kPulseExcessUs);
    }
}

// In the gap between two refreshes, write the pulses of all servos, and set the time at which the
// next refresh begins. Outside the gap, do nothing.
void write_in_gap() {
    const uint16_t ticks = servo_timer::gap_ticks();
    if (ticks < 2 * kMinGapUs) return;
    write_pulses();
    int32_t delay_us = static_cast<int32_t>(frame_due_us + kPulseDelayUs - ::micros());
    while (delay_us < kMinGapUs) delay_us += frame_length_us;
    servo_timer::begin_in(2 * static_cast<uint16_t>(delay_us));
}

}  // namespace

void begin() {
    for (uint8_t i = 0; i < firmware::joint_count; ++i) {
        digitalWrite(board::servo_pin(i), LOW);
        pinMode(board::servo_pin(i), OUTPUT);
    }
}

// One pulse for each joint, 2.5 ms at the longest, and a gap of 2.5 ms, in which the next pulses
// are written.
uint16_t min_frame_us() { return firmware::kMaxPulseUs * (firmware::joint_count + 1); }

void begin_frames(uint16_t frame_us, uint16_t) {
    frame_length_us = frame_us;
    servo_timer::begin(frame_us);
}

void service() {
    if (pulses_pending) write_in_gap();
    servo_timer::stretch();
    if (detach_pending) detach_between_pulses();
}

bool quiet() { return !detach_pending && !pulses_pending; }

bool answers() { return true; }

// Interrupts are off because Servo::attach() begins with the width from before the last detach():
// no pulse may start until the new width is written.
void attach(uint8_t joint, int16_t pulse_us) {
    detach_pending = false;
    noInterrupts();
    if (!servos[joint].attached()) {
        servos[joint].attach(board::servo_pin(joint), firmware::kMinPulseUs, firmware::kMaxPulseUs);
    }
    servos[joint].writeMicroseconds(pulse_us - board::kPulseExcessUs);
    interrupts();
}

void detach() { detach_pending = true; }

// Pulses that have been pending for a whole frame found no gap. They are written at once: old and
// new pulses within one refresh are better than a lost frame.
void pulses(const int16_t (&pulse_us)[firmware::kMaxJoints], uint32_t due_us) {
    if (pulses_pending) write_pulses();
    for (uint8_t i = 0; i < firmware::joint_count; ++i) pending_pulse_us[i] = pulse_us[i];
    frame_due_us = due_us;
    pulses_pending = true;
    write_in_gap();
}

}  // namespace servo_driver
#endif
