// Thin calls into the Arduino core and avr-libc.
#include "arduino_hardware.h"

#include <Arduino.h>
#include <avr/eeprom.h>

#include "start.h"

void ArduinoHardware::begin() {
    serial_port::begin();
    servo_driver::begin();
}

void ArduinoHardware::service() {
    serial_port::poll();
    servo_driver::service();
}

uint32_t ArduinoHardware::micros() { return ::micros(); }

uint16_t ArduinoHardware::unused_ram() { return untouched_ram(); }

uint8_t ArduinoHardware::read(uint16_t address) {
    return eeprom_read_byte(reinterpret_cast<const uint8_t*>(address));
}

void ArduinoHardware::write(uint16_t address, uint8_t byte) {
    eeprom_write_byte(reinterpret_cast<uint8_t*>(address), byte);
}

bool ArduinoHardware::ready() { return eeprom_is_ready(); }
