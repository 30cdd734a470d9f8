// The controller's view of an Arduino: its clock, serial port, servos and EEPROM.
#pragma once

#include "hardware.h"
#include "serial_port.h"
#include "servo_driver.h"

class ArduinoHardware : public firmware::Hardware {
  public:
    void begin();
    // Once a pass of the loop: sends bytes, and what the servo driver has to do.
    void service();
    // Nothing to send or to hand over: the loop may sleep.
    bool quiet() const { return serial_port::queues.output.empty() && servo_driver::quiet(); }

    uint32_t micros() override;
    firmware::SerialQueues& serial() override { return serial_port::queues; }
    void attach(uint8_t joint, int16_t pulse_us) override { servo_driver::attach(joint, pulse_us); }
    void detach() override { servo_driver::detach(); }
    void pulses(const int16_t (&pulse_us)[firmware::kMaxJoints], uint32_t due_us) override {
        servo_driver::pulses(pulse_us, due_us);
    }
    bool output_answers() override { return servo_driver::answers(); }
    uint16_t min_frame_us() const override { return servo_driver::min_frame_us(); }
    void begin_frames(uint16_t frame_us, uint16_t oscillator_khz) override {
        servo_driver::begin_frames(frame_us, oscillator_khz);
    }
    uint16_t unused_ram() override;

    uint8_t read(uint16_t address) override;
    void write(uint16_t address, uint8_t byte) override;
    bool ready() override;
};
