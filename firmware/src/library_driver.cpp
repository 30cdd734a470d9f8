// Servos at the board's own pins, by the Servo library, whose refresh is locked to the frames.
#ifndef SERPENOID_PCA9685
#include <Arduino.h>
#include <Servo.h>

#include "board.h"
#include "servo_driver.h"
#include "servo_timer.h"
#include "settings.h"

namespace servo_driver {
namespace {

// From the time that a frame is due until its pulses begin: time to compute them, even if late.
const uint16_t kHandoverUs = 3000;
// Handing over takes up to 60 µs, interrupts up to 40 µs more.
const uint16_t kMinGapUs = 150;

Servo servos[firmware::kMaxJoints];
int16_t widths_us[firmware::kMaxJoints];
uint32_t frame_due_us;  // when the frame of these pulses was due
uint16_t length_us;     // of a frame
bool waiting;           // they have not been handed over yet
bool letting_go;

// The Servo library leaves a pin high if its servo is detached in the middle of a pulse: wait for
// low.
void let_go() {
    letting_go = false;
    for (uint8_t i = 0; i < firmware::joint_count; ++i) {
        if (!servos[i].attached()) continue;
        noInterrupts();
        const bool low = digitalRead(board::servo_pin(i)) == LOW;
        if (low) servos[i].detach();
        interrupts();
        if (!low) letting_go = true;
    }
}

void write_pulses() {
    waiting = false;
    for (uint8_t i = 0; i < firmware::joint_count; ++i) {
        if (widths_us[i] != 0) servos[i].writeMicroseconds(widths_us[i] - board::kPulseExcessUs);
    }
}

// All at once, in the gap between two refreshes; and the next refresh is made to begin on time.
void hand_over() {
    const uint16_t ticks = servo_timer::gap_ticks();
    if (ticks < 2 * kMinGapUs) return;
    write_pulses();
    int32_t left_us = static_cast<int32_t>(frame_due_us + kHandoverUs - ::micros());
    while (left_us < kMinGapUs) left_us += length_us;
    servo_timer::begin_in(2 * static_cast<uint16_t>(left_us));
}

}  // namespace

void begin() {
    for (uint8_t i = 0; i < firmware::joint_count; ++i) {
        digitalWrite(board::servo_pin(i), LOW);
        pinMode(board::servo_pin(i), OUTPUT);
    }
}

// The pulses follow one another, 2.5 ms at the longest, and then comes a gap of 2.5 ms, in which
// the next ones are handed over.
uint16_t min_frame_us() { return firmware::kMaxPulseUs * (firmware::joint_count + 1); }

void begin_frames(uint16_t frame_us, uint16_t) {
    length_us = frame_us;
    servo_timer::begin(frame_us);
}

void service() {
    if (waiting) hand_over();
    servo_timer::stretch();
    if (letting_go) let_go();
}

bool quiet() { return !letting_go && !waiting; }

bool answers() { return true; }

// No pulse may start between attach(), which leaves the width of the last time, and the new width.
void attach(uint8_t joint, int16_t pulse_us) {
    letting_go = false;
    noInterrupts();
    if (!servos[joint].attached()) {
        servos[joint].attach(board::servo_pin(joint), firmware::kMinPulseUs, firmware::kMaxPulseUs);
    }
    servos[joint].writeMicroseconds(pulse_us - board::kPulseExcessUs);
    interrupts();
}

void detach() { letting_go = true; }

// What still waits then, a whole frame long, has no gap to wait for: better mixed than never.
void pulses(const int16_t (&pulse_us)[firmware::kMaxJoints], uint32_t due_us) {
    if (waiting) write_pulses();
    for (uint8_t i = 0; i < firmware::joint_count; ++i) widths_us[i] = pulse_us[i];
    frame_due_us = due_us;
    waiting = true;
    hand_over();
}

}  // namespace servo_driver
#endif
