// Thin calls into the Arduino core, the Servo library and avr-libc.
#include "arduino_hardware.h"

#include <Arduino.h>
#include <avr/eeprom.h>

#include "board.h"
#include "settings.h"
#include "start.h"

void ArduinoHardware::begin() {
    Serial.begin(board::kBaud);
    Serial.write('\n');  // ends whatever a boot loader has left on the line
    for (uint8_t pin : board::kServoPins) {
        digitalWrite(pin, LOW);
        pinMode(pin, OUTPUT);
    }
}

// The Servo library leaves a pin high if its servo is detached in the middle of a pulse: wait for
// low.
void ArduinoHardware::let_go() {
    letting_go_ = false;
    for (uint8_t i = 0; i < firmware::kJoints; ++i) {
        if (!servos_[i].attached()) continue;
        noInterrupts();
        const bool low = digitalRead(board::kServoPins[i]) == LOW;
        if (low) servos_[i].detach();
        interrupts();
        if (!low) letting_go_ = true;
    }
}

void ArduinoHardware::service() {
    output_.poll();
    if (letting_go_) let_go();
}

uint32_t ArduinoHardware::micros() { return ::micros(); }

int16_t ArduinoHardware::receive() {
    const int waiting = Serial.available();
    if (waiting == 0) return -1;
    if (waiting == SERIAL_RX_BUFFER_SIZE - 1 && overflows_ < 65535) ++overflows_;
    return static_cast<int16_t>(Serial.read());
}

void ArduinoHardware::transmit(const char* text, uint8_t length) { output_.write(text, length); }

// No pulse may start between attach(), which leaves the width of the last time, and the new width.
void ArduinoHardware::attach(const int16_t (&pulse_us)[firmware::kJoints]) {
    letting_go_ = false;
    for (uint8_t i = 0; i < firmware::kJoints; ++i) {
        noInterrupts();
        if (!servos_[i].attached()) {
            servos_[i].attach(board::kServoPins[i], firmware::kLeastPulseUs,
                              firmware::kMostPulseUs);
        }
        servos_[i].writeMicroseconds(pulse_us[i] - board::kPulseExcessUs);
        interrupts();
    }
}

void ArduinoHardware::pulse(uint8_t joint, int16_t pulse_us) {
    servos_[joint].writeMicroseconds(pulse_us - board::kPulseExcessUs);
}

uint16_t ArduinoHardware::unused_ram() { return untouched_ram(); }

uint8_t ArduinoHardware::read(uint16_t address) {
    return eeprom_read_byte(reinterpret_cast<const uint8_t*>(address));
}

void ArduinoHardware::write(uint16_t address, uint8_t byte) {
    eeprom_write_byte(reinterpret_cast<uint8_t*>(address), byte);
}

bool ArduinoHardware::ready() { return eeprom_is_ready(); }
