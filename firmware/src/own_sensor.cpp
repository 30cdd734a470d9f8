// YOUR SENSOR HERE: what each line of telemetry shows as `sensor=`, with -D SERPENOID_SENSOR.
#ifdef SERPENOID_SENSOR
#include <Arduino.h>

#include "telemetry.h"

namespace firmware {

// Return a reading, once for each line of telemetry; it may take 0.5 ms. Here: the voltage at A3,
// 0 to 1023 for 0 to 5 V, such as a battery's behind a divider. It takes 0.11 ms.
int16_t own_sensor() { return static_cast<int16_t>(analogRead(A3)); }

}  // namespace firmware
#endif
