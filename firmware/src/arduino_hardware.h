// The controller's view of an Arduino: its clock, serial port, servos and EEPROM.
#pragma once

#include <Servo.h>

#include "hardware.h"
#include "serial_port.h"

class ArduinoHardware : public firmware::Hardware {
  public:
    void begin();
    // Once a pass of the loop: sends, hands pulses over, lets servos go that have been told to.
    void service();
    // Nothing to send, to hand over or to let go: the loop may sleep.
    bool quiet() const { return serial_port::queues.out.empty() && !letting_go_ && !waiting_; }

    uint32_t micros() override;
    firmware::SerialQueues& serial() override { return serial_port::queues; }
    void attach(uint8_t joint, int16_t pulse_us) override;
    void detach() override { letting_go_ = true; }
    void pulses(const int16_t (&pulse_us)[firmware::kJoints], uint32_t due_us) override;
    uint16_t unused_ram() override;

    uint8_t read(uint16_t address) override;
    void write(uint16_t address, uint8_t byte) override;
    bool ready() override;

  private:
    void let_go();
    void hand_over();
    void write_pulses();

    Servo servos_[firmware::kJoints];
    int16_t pulse_us_[firmware::kJoints];
    uint32_t due_us_;  // when the frame of these pulses was due
    bool waiting_;     // they have not been handed over yet
    bool letting_go_;
};
