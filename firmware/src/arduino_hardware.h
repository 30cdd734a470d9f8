// The controller's view of an Arduino: its clock, serial port, servos and EEPROM.
#pragma once

#include <Servo.h>

#include "hardware.h"
#include "polled_output.h"

class ArduinoHardware : public firmware::Hardware {
  public:
    void begin();
    // Once a pass of the loop: sends, and lets servos go that have been told to.
    void service();
    // Nothing to send and nothing to let go: the loop may sleep.
    bool quiet() const { return output_.empty() && !letting_go_; }

    uint32_t micros() override;
    int16_t receive() override;
    uint16_t receive_overflows() override { return overflows_; }
    uint16_t room() override { return output_.room(); }
    void transmit(const char* text, uint8_t length) override;
    void attach(const int16_t (&pulse_us)[firmware::kJoints]) override;
    void detach() override { letting_go_ = true; }
    void pulse(uint8_t joint, int16_t pulse_us) override;
    uint16_t unused_ram() override;

    uint8_t read(uint16_t address) override;
    void write(uint16_t address, uint8_t byte) override;
    bool ready() override;

  private:
    void let_go();

    firmware::PolledOutput output_;
    Servo servos_[firmware::kJoints];
    uint16_t overflows_;
    bool letting_go_;
};
