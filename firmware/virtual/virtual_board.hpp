// A simulated board: the firmware's controller with simulated clock, serial line, servos and
// EEPROM.
//
// Time advances in steps of one byte on the line (40 µs). Each step carries one byte in each
// direction and polls the controller once. It is C++11, because the tests of the firmware include
// it.
#pragma once

#include <deque>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "controller.h"

namespace firmware {

class VirtualBoard : public Hardware {
  public:
    static const uint32_t kByteUs = 40;  // 10 bits at 250000 baud
    static const uint16_t kEepromBytes = 1024;
    static const uint32_t kEepromWriteUs = 3400;

    explicit VirtualBoard(uint64_t start_us = 0)
        : eeprom_(kEepromBytes, 0xFF),
          now_us_(start_us),
          eeprom_busy_until_us_(0),
          attached_(0),
          pulse_us_() {}

    // Start as after a reset: the EEPROM is kept, bytes on the line are lost.
    void boot(Reset reset, uint32_t first_frame = 0, const char* name = "virtual") {
        to_board_.clear();
        serial_ = SerialQueues();
        attached_ = 0;
        for (int16_t& pulse : pulse_us_) pulse = 0;
        controller_.reset(new Controller(*this));
        controller_->begin(Start{name, reset, first_frame});
    }

    void run(uint64_t duration_us) {
        controller();
        const uint64_t end_us = now_us_ + duration_us;
        while (now_us_ < end_us) step();
    }

    // Advance the clock without polling the controller, as if the program hung.
    void stall(uint64_t duration_us) { now_us_ += duration_us; }

    void send_to_board(const std::string& bytes) {
        to_board_.insert(to_board_.end(), bytes.begin(), bytes.end());
    }
    std::string take_output() {
        std::string bytes;
        bytes.swap(from_board_);
        return bytes;
    }

    const Controller& controller() const {
        if (!controller_) throw std::logic_error("the board has not been booted");
        return *controller_;
    }
    uint64_t now_us() const { return now_us_; }
    // The number of servos that get pulses, counted from the tail.
    uint8_t attached() const { return attached_; }
    int16_t servo_us(uint8_t joint) const { return joint < attached_ ? pulse_us_[joint] : 0; }
    std::vector<uint8_t>& eeprom() { return eeprom_; }

    uint32_t micros() override { return static_cast<uint32_t>(now_us_); }
    SerialQueues& serial() override { return serial_; }
    void attach(uint8_t joint, int16_t pulse_us) override {
        attached_ = static_cast<uint8_t>(joint + 1);
        pulse_us_[joint] = pulse_us;
    }
    void detach() override { attached_ = 0; }
    void pulses(const int16_t (&pulse_us)[kMaxJoints], uint32_t) override {
        for (uint8_t i = 0; i < attached_; ++i) pulse_us_[i] = pulse_us[i];
    }
    // For 8 joints or more as with the Servo library (pulses of 2.5 ms one after the other); for
    // fewer the least value of the setting `frame`.
    uint16_t min_frame_us() const override {
        return joint_count <= 7 ? 3000 : kMaxPulseUs * (joint_count + 1);
    }
    void begin_frames(uint16_t, uint16_t) override {}
    uint16_t unused_ram() override { return 0; }

    uint8_t read(uint16_t address) override { return eeprom_.at(address); }
    bool ready() override { return now_us_ >= eeprom_busy_until_us_; }
    void write(uint16_t address, uint8_t byte) override {
        eeprom_.at(address) = byte;
        eeprom_busy_until_us_ = now_us_ + kEepromWriteUs;
    }

  private:
    void step() {
        now_us_ += kByteUs;
        if (!to_board_.empty()) {
            serial_.input.push(static_cast<uint8_t>(to_board_.front()));
            to_board_.pop_front();
        }
        if (!serial_.output.empty())
            from_board_.push_back(static_cast<char>(serial_.output.take()));
        controller_->poll();
    }

    std::unique_ptr<Controller> controller_;
    SerialQueues serial_;
    std::deque<char> to_board_;
    std::string from_board_;
    std::vector<uint8_t> eeprom_;
    uint64_t now_us_, eeprom_busy_until_us_;
    uint8_t attached_;
    int16_t pulse_us_[kMaxJoints];
};

}  // namespace firmware
