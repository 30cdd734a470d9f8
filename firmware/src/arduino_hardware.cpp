// Thin calls into the Arduino core, the Servo library and avr-libc.
#include "arduino_hardware.h"

#include <Arduino.h>
#include <avr/eeprom.h>

#include "board.h"
#include "serial_port.h"
#include "servo_timer.h"
#include "settings.h"
#include "start.h"

namespace {

// From the time that a frame is due until its pulses begin: time to compute them, even if late.
const uint16_t kHandoverUs = 3000;
// Handing over takes up to 60 µs, interrupts up to 40 µs more.
const uint16_t kLeastGapUs = 150;

}  // namespace

void ArduinoHardware::begin() {
    serial_port::begin();
    for (uint8_t i = 0; i < firmware::kJoints; ++i) {
        digitalWrite(board::servo_pin(i), LOW);
        pinMode(board::servo_pin(i), OUTPUT);
    }
}

// The Servo library leaves a pin high if its servo is detached in the middle of a pulse: wait for
// low.
void ArduinoHardware::let_go() {
    letting_go_ = false;
    for (uint8_t i = 0; i < firmware::kJoints; ++i) {
        if (!servos_[i].attached()) continue;
        noInterrupts();
        const bool low = digitalRead(board::servo_pin(i)) == LOW;
        if (low) servos_[i].detach();
        interrupts();
        if (!low) letting_go_ = true;
    }
}

void ArduinoHardware::service() {
    serial_port::poll();
    if (waiting_) hand_over();
    servo_timer::stretch();
    if (letting_go_) let_go();
}

uint32_t ArduinoHardware::micros() { return ::micros(); }

// No pulse may start between attach(), which leaves the width of the last time, and the new width.
void ArduinoHardware::attach(uint8_t joint, int16_t pulse_us) {
    letting_go_ = false;
    noInterrupts();
    if (!servos_[joint].attached()) {
        servos_[joint].attach(board::servo_pin(joint), firmware::kLeastPulseUs,
                              firmware::kMostPulseUs);
    }
    servos_[joint].writeMicroseconds(pulse_us - board::kPulseExcessUs);
    interrupts();
}

// What still waits then, a whole frame long, has no gap to wait for: better mixed than never.
void ArduinoHardware::pulses(const int16_t (&pulse_us)[firmware::kJoints], uint32_t due_us) {
    if (waiting_) write_pulses();
    for (uint8_t i = 0; i < firmware::kJoints; ++i) pulse_us_[i] = pulse_us[i];
    due_us_ = due_us;
    waiting_ = true;
    hand_over();
}

// All at once, in the gap between two refreshes; and the next refresh is made to begin on time.
void ArduinoHardware::hand_over() {
    const uint16_t ticks = servo_timer::gap_ticks();
    if (ticks < 2 * kLeastGapUs) return;
    write_pulses();
    int32_t left_us = static_cast<int32_t>(due_us_ + kHandoverUs - ::micros());
    while (left_us < kLeastGapUs) left_us += firmware::kFrameUs;
    servo_timer::begin_in(2 * static_cast<uint16_t>(left_us));
}

void ArduinoHardware::write_pulses() {
    waiting_ = false;
    for (uint8_t i = 0; i < firmware::kJoints; ++i) {
        if (pulse_us_[i] != 0) servos_[i].writeMicroseconds(pulse_us_[i] - board::kPulseExcessUs);
    }
}

uint16_t ArduinoHardware::unused_ram() { return untouched_ram(); }

uint8_t ArduinoHardware::read(uint16_t address) {
    return eeprom_read_byte(reinterpret_cast<const uint8_t*>(address));
}

void ArduinoHardware::write(uint16_t address, uint8_t byte) {
    eeprom_write_byte(reinterpret_cast<uint8_t*>(address), byte);
}

bool ArduinoHardware::ready() { return eeprom_is_ready(); }
