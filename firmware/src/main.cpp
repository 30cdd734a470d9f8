// The board's programme, as a table of contents.
#include <Arduino.h>
#include <avr/sleep.h>
#include <avr/wdt.h>

#include "arduino_hardware.h"
#include "board.h"
#include "controller.h"
#include "start.h"

namespace {

ArduinoHardware hardware;
firmware::Controller controller(hardware);

// Timer 0 wakes the board every 1.024 ms: sleeping is safe only while nothing is due sooner.
const uint32_t kTooSoonToSleepUs = 1200;

}  // namespace

void setup() {
    hardware.begin();
    controller.begin(firmware::Start{board::kName, reset_cause(), 0});
    if (board::kWatchdog) wdt_enable(WDTO_30MS);
}

void loop() {
    if (board::kWatchdog) wdt_reset();
    hardware.service();
    controller.poll();
    if (!hardware.quiet() || !controller.quiet() || controller.uses_eeprom()) return;
    if (controller.spare_us() > kTooSoonToSleepUs) sleep_mode();
}
