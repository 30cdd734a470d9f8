// Servos at a PCA9685, 16 channels behind two wires; its outputs are enabled by a pin of the board.
//
// All channels are written in one burst and change together, at the end of the chip's own cycle,
// which is a frame to within 2.4 % and is not locked to it. The pin that enables them (/OE, low)
// floats while the board resets, and a resistor pulls it up: so a reset, or a bus that fell silent,
// ends all pulses without a word to the chip.
#ifdef SERPENOID_PCA9685
#include <Arduino.h>

#include "board.h"
#include "servo_driver.h"
#include "two_wire.h"

namespace servo_driver {
namespace {

const uint8_t kDevice = 0x40;
const uint8_t kGeneralCall = 0x00, kSoftwareReset = 0x06;
const uint8_t kMode1 = 0x00, kFirstChannel = 0x06, kAllOffHigh = 0xFD, kPrescale = 0xFE;
const uint8_t kAwake = 0x20, kAsleep = 0x30;  // MODE1, with registers that count up by themselves
const uint8_t kRestart = 0x80;                // MODE1, where outputs were on when it fell asleep
const uint8_t kFullOff = 0x10;
const uint8_t kMaxPrescale = 255;
const uint16_t kCounts = 4096;  // a cycle
// Computing and sending all joints, with a line to write.
const uint16_t kMinUs = 2000 + 600 * firmware::joint_count;

uint16_t oscillator_khz;  // of this chip
uint8_t prescale;
uint8_t attached;  // joints from the tail
bool good = false;

uint16_t counts_of(int16_t pulse_us) {
    const uint32_t clocks = static_cast<uint32_t>(pulse_us) * oscillator_khz;  // times 1000
    const uint32_t unit = 1000UL * (prescale + 1U);
    return static_cast<uint16_t>((clocks + unit / 2) / unit);
}

void enable(bool on) { digitalWrite(board::kEnablePin, on ? LOW : HIGH); }

bool set_register(uint8_t first, uint8_t value) {
    return two_wire::write(kDevice, first, &value, 1);
}

// All outputs off, then the rate, which can be set only while it sleeps. Before that a software
// reset for all chips: else one that was told once to use an external clock keeps to it (EXTCLK).
bool start() {
    good = set_register(kMode1, kAsleep) && two_wire::write(kGeneralCall, kSoftwareReset, 0, 0) &&
           set_register(kMode1, kAsleep) && set_register(kAllOffHigh, kFullOff) &&
           set_register(kPrescale, prescale) && set_register(kMode1, kAwake);
    delayMicroseconds(500);  // until its oscillator runs
    return good;
}

// Every channel, in one burst; each begins a sixteenth of a cycle after its neighbour, so that the
// servos do not start together.
bool write_channels(const int16_t* pulse_us) {
    uint8_t bytes[4 * firmware::joint_count], *next = bytes;
    for (uint8_t i = 0; i < firmware::joint_count; ++i) {
        const uint16_t start = static_cast<uint16_t>(i * (kCounts / 16));
        const bool is_off = i >= attached || pulse_us[i] == 0;
        const uint16_t end = (start + (is_off ? 0 : counts_of(pulse_us[i]))) % kCounts;
        *next++ = static_cast<uint8_t>(start);
        *next++ = static_cast<uint8_t>(start >> 8);
        *next++ = static_cast<uint8_t>(end);
        *next++ = static_cast<uint8_t>(is_off ? kFullOff : end >> 8);
    }
    return two_wire::write(kDevice, kFirstChannel, bytes, sizeof bytes);
}

}  // namespace

void begin() {
    enable(false);
    pinMode(board::kEnablePin, OUTPUT);
    enable(false);
    two_wire::begin();
}

uint16_t min_frame_us() { return kMinUs; }

void begin_frames(uint16_t frame_us, uint16_t khz) {
    oscillator_khz = khz;
    const uint32_t clocks = static_cast<uint32_t>(frame_us) * khz / 1000;
    const uint32_t ratio = (clocks + kCounts / 2) / kCounts;
    prescale = static_cast<uint8_t>(ratio > kMaxPrescale ? kMaxPrescale : ratio - 1);
    start();
}

void service() {}

bool quiet() { return true; }

// A chip that lost its power for a moment sleeps, and runs at another rate: it is begun anew only
// when nothing is attached.
bool answers() {
    if (good) good = (two_wire::read(kDevice, kMode1) & ~kRestart) == kAwake;
    if (!good && attached == 0) start();
    if (!good) enable(false);
    return good;
}

void attach(uint8_t joint, int16_t pulse_us) {
    attached = static_cast<uint8_t>(joint + 1);
    (void)pulse_us;  // the next frame's pulses are the same
    enable(good);
}

void detach() {
    attached = 0;
    enable(false);
    good = set_register(kAllOffHigh, kFullOff);
}

void pulses(const int16_t (&pulse_us)[firmware::kMaxJoints], uint32_t) {
    if (good && write_channels(pulse_us)) return;
    good = false;
    enable(false);
}

}  // namespace servo_driver
#endif
