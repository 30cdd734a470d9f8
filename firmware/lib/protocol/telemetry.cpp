// The only line whose labels carry values: a plotter draws t and the five joints, nothing else.
#include "telemetry.h"

#include "progmem.h"

namespace firmware {

void write_telemetry(Text& line, const Frame& frame) {
    line.put_flash(FLASH_TEXT("t:")).put_unsigned(frame.number);
    for (uint8_t i = 0; i < kJoints; ++i) {
        line.put_flash(FLASH_TEXT(" j")).put(static_cast<char>('1' + i)).put(':');
        line.put_fixed(cdeg_from_q14(frame.setpoint_q14[i]), 2);
    }
    line.put_flash(FLASH_TEXT(" us=")).put_unsigned(frame.start_us);
    line.put_flash(FLASH_TEXT(" ph="))
        .put_fixed(static_cast<int32_t>(mdeg_from_phase(frame.phase)), 3);
    for (uint8_t i = 0; i < kJoints; ++i) {
        line.put_flash(i == 0 ? FLASH_TEXT(" p=") : FLASH_TEXT(","));
        line.put_unsigned(static_cast<uint32_t>(frame.pulse_us[i]));
    }
    line.put_flash(FLASH_TEXT(" ex="))
        .put_unsigned(frame.run_us)
        .put_flash(FLASH_TEXT(" la="))
        .put_unsigned(frame.late_us);
    line.put_flash(FLASH_TEXT(" st=")).put_flash(frame.state).finish();
}

}  // namespace firmware
