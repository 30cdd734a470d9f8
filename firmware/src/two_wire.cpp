// The two-wire bus by the TWI unit of the AVR; for status codes see its data sheet.
#ifdef SERPENOID_PCA9685
#include "two_wire.h"

#include <Arduino.h>
#include <util/twi.h>

#include "serial_port.h"

namespace two_wire {
namespace {

const uint32_t kBusHz = 400000;
const uint8_t kMaxPolls = 200;  // number of polls in some 0.3 ms; a byte takes 23 µs

// Do one step of the bus, and send bytes to the host meanwhile. True if it ends with this status.
bool step(uint8_t control, uint8_t expected_status) {
    TWCR = static_cast<uint8_t>(_BV(TWINT) | _BV(TWEN) | control);
    for (uint8_t polls = kMaxPolls; !(TWCR & _BV(TWINT));) {
        if (--polls == 0) return false;
        serial_port::poll();
    }
    return TW_STATUS == expected_status;
}

bool send(uint8_t byte, uint8_t expected_status) {
    TWDR = byte;
    return step(0, expected_status);
}

bool address(uint8_t started, uint8_t device, uint8_t first) {
    return step(_BV(TWSTA), started) && send(static_cast<uint8_t>(device << 1), TW_MT_SLA_ACK) &&
           send(first, TW_MT_DATA_ACK);
}

bool burst(uint8_t started, uint8_t device, uint8_t first, const uint8_t* bytes, uint8_t count) {
    bool good = address(started, device, first);
    for (uint8_t i = 0; good && i < count; ++i) good = send(bytes[i], TW_MT_DATA_ACK);
    return good;
}

bool fetch(uint8_t started, uint8_t device, uint8_t first) {
    return address(started, device, first) && step(_BV(TWSTA), TW_REP_START) &&
           send(static_cast<uint8_t>(device << 1 | 1), TW_MR_SLA_ACK) && step(0, TW_MR_DATA_NACK);
}

// Clock the bus until the data line is free. If a reset interrupts a byte, the chip holds the data
// line until it has got nine clocks, and the TWI unit would wait for ever.
void release() {
    TWCR = 0;
    for (uint8_t clocks = 9; clocks != 0 && digitalRead(SDA) == LOW; --clocks) {
        pinMode(SCL, OUTPUT);  // low, as its output was never set high
        delayMicroseconds(5);
        pinMode(SCL, INPUT);
        delayMicroseconds(5);
    }
}

// Send a STOP. If the unit hangs, switch it off and free the bus. False if anything failed.
bool end(bool good) {
    TWCR = _BV(TWINT) | _BV(TWEN) | _BV(TWSTO);
    for (uint8_t polls = kMaxPolls; TWCR & _BV(TWSTO);) {
        if (--polls != 0) continue;
        good = false;
        break;
    }
    if (!good) release();
    return good;
}

}  // namespace

void begin() {
    TWSR = 0;
    TWBR = static_cast<uint8_t>((F_CPU / kBusHz - 16) / 2);
    release();
}

// Noise of servos may spoil an acknowledgement, so each transfer is tried twice, the second time
// after a repeated START: after a STOP the chip would output half a frame.
bool write(uint8_t device, uint8_t first, const uint8_t* bytes, uint8_t count) {
    return end(burst(TW_START, device, first, bytes, count) ||
               burst(TW_REP_START, device, first, bytes, count));
}

int16_t read(uint8_t device, uint8_t first) {
    const bool good = fetch(TW_START, device, first) || fetch(TW_REP_START, device, first);
    const uint8_t byte = TWDR;
    return end(good) ? byte : -1;
}

}  // namespace two_wire
#endif
