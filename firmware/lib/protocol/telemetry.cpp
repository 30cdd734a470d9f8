// The only line whose labels carry values: a plotter draws t and the joints, nothing else.
#include "telemetry.h"

#include "progmem.h"

namespace firmware {

bool write_telemetry(Output& line, const Frame& frame) {
    line.begin().put_flash(FLASH_TEXT("t:")).put_unsigned(frame.number);
    for (uint8_t i = 0; i < joint_count; ++i) {
        line.put_flash(FLASH_TEXT(" j")).put_unsigned(i + 1U).put(':');
        line.put_fixed(cdeg_from_q14(frame.setpoint_q14[i]), 2);
    }
    line.put_flash(FLASH_TEXT(" board_us=")).put_unsigned(frame.board_us);
    line.put_flash(FLASH_TEXT(" ph="));
    line.put_fixed(static_cast<int32_t>(mdeg_from_phase(frame.phase)), 3);
    for (uint8_t i = 0; i < joint_count; ++i) {
        line.put_flash(i == 0 ? FLASH_TEXT(" p=") : FLASH_TEXT(","));
        line.put_unsigned(static_cast<uint32_t>(frame.pulse_us[i]));
    }
    line.put_flash(FLASH_TEXT(" exec_us=")).put_unsigned(frame.exec_us);
    line.put_flash(FLASH_TEXT(" late_us=")).put_unsigned(frame.late_us);
    line.put_flash(FLASH_TEXT(" clipped=")).put_unsigned(frame.clipped);
    line.put_flash(FLASH_TEXT(" st=")).put_flash(frame.state);
#ifdef SERPENOID_SENSOR
    line.put_flash(FLASH_TEXT(" sensor=")).put_fixed(own_sensor(), 0);
#endif
    return line.finish();
}

}  // namespace firmware
