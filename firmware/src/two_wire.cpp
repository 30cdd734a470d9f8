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

// Do one step of the bus, and send bytes to the host while it lasts. Return whether the TWI unit
// reports the expected status in time.
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

bool select_register(uint8_t start_status, uint8_t device, uint8_t register_address) {
    return step(_BV(TWSTA), start_status) &&
           send(static_cast<uint8_t>(device << 1), TW_MT_SLA_ACK) &&
           send(register_address, TW_MT_DATA_ACK);
}

bool try_write(uint8_t start_status, uint8_t device, uint8_t register_address, const uint8_t* bytes,
               uint8_t count) {
    bool ok = select_register(start_status, device, register_address);
    for (uint8_t i = 0; ok && i < count; ++i) ok = send(bytes[i], TW_MT_DATA_ACK);
    return ok;
}

bool try_read(uint8_t start_status, uint8_t device, uint8_t register_address) {
    return select_register(start_status, device, register_address) &&
           step(_BV(TWSTA), TW_REP_START) &&
           send(static_cast<uint8_t>(device << 1 | 1), TW_MR_SLA_ACK) && step(0, TW_MR_DATA_NACK);
}

// Clock the bus until the data line is free. If a reset interrupts a byte, the chip holds the data
// line until it has got nine clocks, and the TWI unit would wait for ever.
void free_data_line() {
    TWCR = 0;
    for (uint8_t clocks = 9; clocks != 0 && digitalRead(SDA) == LOW; --clocks) {
        pinMode(SCL, OUTPUT);  // drives the clock low: the output latch of SCL is 0
        delayMicroseconds(5);
        pinMode(SCL, INPUT);
        delayMicroseconds(5);
    }
}

// Send a STOP. If the transfer failed (ok is false) or the STOP does not end, switch the unit off
// and free the bus. Return whether both succeeded.
bool finish(bool ok) {
    TWCR = _BV(TWINT) | _BV(TWEN) | _BV(TWSTO);
    for (uint8_t polls = kMaxPolls; TWCR & _BV(TWSTO);) {
        if (--polls != 0) continue;
        ok = false;
        break;
    }
    if (!ok) free_data_line();
    return ok;
}

}  // namespace

void begin() {
    TWSR = 0;
    TWBR = static_cast<uint8_t>((F_CPU / kBusHz - 16) / 2);
    free_data_line();
}

// Electrical noise of servos may spoil an acknowledgement, so each transfer is tried twice. The
// second try begins with a repeated START, because at a STOP the PCA9685 would put the part of the
// frame that it has received on its outputs.
bool write(uint8_t device, uint8_t register_address, const uint8_t* bytes, uint8_t count) {
    return finish(try_write(TW_START, device, register_address, bytes, count) ||
                  try_write(TW_REP_START, device, register_address, bytes, count));
}

int16_t read(uint8_t device, uint8_t register_address) {
    const bool ok = try_read(TW_START, device, register_address) ||
                    try_read(TW_REP_START, device, register_address);
    const uint8_t byte = TWDR;
    return finish(ok) ? byte : -1;
}

}  // namespace two_wire
#endif
