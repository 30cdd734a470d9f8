// Servos at a PCA9685, a chip of 16 pulse outputs (channels) on the I²C bus. A pin of the board
// enables its outputs.
//
// All channels are written in one transfer, and their pulses change together at the end of the
// chip's cycle. This cycle is as long as a frame to within 2.4 %, but not synchronised with it.
//
// The enabling pin (/OE) is active when low. While the board resets, the pin floats and a resistor
// pulls it up, so a reset ends all pulses. If the bus fails, the board sets the pin high. Neither
// needs a transfer to the chip.
#ifdef SERPENOID_PCA9685
#include <Arduino.h>

#include "board.h"
#include "servo_driver.h"
#include "two_wire.h"

namespace servo_driver {
namespace {

const uint8_t kChipAddress = 0x40;
const uint8_t kGeneralCall = 0x00, kSoftwareReset = 0x06;
const uint8_t kMode1 = 0x00, kFirstChannel = 0x06, kAllOffHigh = 0xFD, kPrescale = 0xFE;
// Values of MODE1; both set AI, so that one transfer writes consecutive registers.
const uint8_t kAwake = 0x20, kAsleep = 0x30;
const uint8_t kRestart = 0x80;  // bit of MODE1: outputs were on when the chip went to sleep
const uint8_t kFullOff = 0x10;
const uint8_t kMaxPrescale = 255;
const uint16_t kCycleCounts = 4096;  // resolution of the chip: counts in a cycle
// Time to compute and send the pulses of all joints and to write a line to the host.
const uint16_t kMinFrameUs = 2000 + 600 * firmware::joint_count;

uint16_t oscillator_khz;  // differs from chip to chip
uint8_t prescale;
uint8_t attached_count;  // number of joints with pulses, from the tail
bool responds = false;

uint16_t pulse_counts(int16_t pulse_us) {
    const uint32_t milliclocks = static_cast<uint32_t>(pulse_us) * oscillator_khz;
    const uint32_t milliclocks_per_count = 1000UL * (prescale + 1U);
    return static_cast<uint16_t>((milliclocks + milliclocks_per_count / 2) / milliclocks_per_count);
}

void enable_outputs(bool on) { digitalWrite(board::kEnablePin, on ? LOW : HIGH); }

bool set_register(uint8_t register_address, uint8_t value) {
    return two_wire::write(kChipAddress, register_address, &value, 1);
}

// Reset the chip, switch all outputs off and set the length of its cycle, which can be set only in
// its sleep. Only a software reset, which goes to all chips on the bus, clears EXTCLK (use of an
// external clock).
bool start_chip() {
    responds = set_register(kMode1, kAsleep) &&
               two_wire::write(kGeneralCall, kSoftwareReset, 0, 0) &&
               set_register(kMode1, kAsleep) && set_register(kAllOffHigh, kFullOff) &&
               set_register(kPrescale, prescale) && set_register(kMode1, kAwake);
    delayMicroseconds(500);  // the oscillator starts in this time
    return responds;
}

// Write all channels in one transfer. Each pulse begins a sixteenth of a cycle after that of the
// joint before, so that the servos do not draw their current at the same time.
bool write_channels(const int16_t* pulse_us) {
    uint8_t bytes[4 * firmware::joint_count], *next = bytes;
    for (uint8_t i = 0; i < firmware::joint_count; ++i) {
        const uint16_t start = static_cast<uint16_t>(i * (kCycleCounts / 16));
        const bool is_off = i >= attached_count || pulse_us[i] == 0;
        const uint16_t end = (start + (is_off ? 0 : pulse_counts(pulse_us[i]))) % kCycleCounts;
        *next++ = static_cast<uint8_t>(start);
        *next++ = static_cast<uint8_t>(start >> 8);
        *next++ = static_cast<uint8_t>(end);
        *next++ = static_cast<uint8_t>(is_off ? kFullOff : end >> 8);
    }
    return two_wire::write(kChipAddress, kFirstChannel, bytes, sizeof bytes);
}

}  // namespace

void begin() {
    enable_outputs(false);
    pinMode(board::kEnablePin, OUTPUT);
    enable_outputs(false);
    two_wire::begin();
}

uint16_t min_frame_us() { return kMinFrameUs; }

void begin_frames(uint16_t frame_us, uint16_t khz) {
    oscillator_khz = khz;
    const uint32_t clocks = static_cast<uint32_t>(frame_us) * khz / 1000;
    const uint32_t ratio = (clocks + kCycleCounts / 2) / kCycleCounts;
    prescale = static_cast<uint8_t>(ratio > kMaxPrescale ? kMaxPrescale : ratio - 1);
    start_chip();
}

void service() {}

bool quiet() { return true; }

// After an interruption of its power the chip sleeps, with another length of cycle. It is started
// again only when no joint has pulses.
bool answers() {
    if (responds) responds = (two_wire::read(kChipAddress, kMode1) & ~kRestart) == kAwake;
    if (!responds && attached_count == 0) start_chip();
    if (!responds) enable_outputs(false);
    return responds;
}

void attach(uint8_t joint, int16_t pulse_us) {
    attached_count = static_cast<uint8_t>(joint + 1);
    (void)pulse_us;  // pulses() of the next frame writes the same width
    enable_outputs(responds);
}

void detach() {
    attached_count = 0;
    enable_outputs(false);
    responds = set_register(kAllOffHigh, kFullOff);
}

void pulses(const int16_t (&pulse_us)[firmware::kMaxJoints], uint32_t) {
    if (responds && write_channels(pulse_us)) return;
    responds = false;
    enable_outputs(false);
}

}  // namespace servo_driver
#endif
