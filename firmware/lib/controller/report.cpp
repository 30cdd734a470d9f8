// Data lines: greeting, status, counters, help, settings, trims. Each pass sends at most one.
#include "controller.h"
#include "progmem.h"

namespace firmware {

void Controller::greet() {
    line_.begin().put_flash(FLASH_TEXT("hello: serpenoid fw=")).put_flash(kVersion);
    line_.put_flash(FLASH_TEXT(" protocol=")).put_unsigned(kProtocol);
    line_.put_flash(FLASH_TEXT(" board=")).put(start_.board);
    line_.put_flash(FLASH_TEXT(" joints=")).put_unsigned(joint_count);
    line_.put_flash(FLASH_TEXT(" frame_us=")).put_unsigned(frame_us());
    line_.put_flash(FLASH_TEXT(" boot=")).put_unsigned(boot_id_);
    line_.put_flash(FLASH_TEXT(" reset=")).put_flash(reset_name(start_.reset));
    line_.put_flash(FLASH_TEXT(" settings=")).put_flash(load_result_name(load_result_));
    line_.put_flash(FLASH_TEXT(" silence="));
    if (settings_.value_u[kSilence] == 0) {
        line_.put_flash(FLASH_TEXT("off"));
    } else {
        line_.put_micro(settings_.value_u[kSilence]);
    }
    send();
}

uint8_t Controller::report_rows() const {
    switch (report_) {
        case Report::Status:
            return 3;
        case Report::Help:
            return kVerbs;
        case Report::Set:
            return kSettingCount;
        case Report::Trim:
            return joint_count;
        default:
            return 0;
    }
}

void Controller::next_report_line() {
    if (report_ == Report::None || !may_answer()) return;
    if (report_row_ == report_rows()) {
        report_ = Report::None;
        report_row_ = 0;
        return verdict(tag_, Refusal());
    }
    line_.begin();
    put_report_line(report_row_++);
    send();
}

void Controller::put_report_line(uint8_t row) {
    switch (report_) {
        case Report::Status:
            return row == 0 ? put_status() : row == 1 ? put_counters() : put_timing();
        case Report::Help:
            line_.put_flash(FLASH_TEXT("help: ")).put_flash(verb_help(row));
            return;
        case Report::Set:
            return put_field(setting(row), settings_.value_u[row]);
        case Report::Trim:
            return put_servo(row);
        default:
            return;
    }
}

void Controller::put_status() {
    line_.put_flash(FLASH_TEXT("status: state=")).put_flash(state_name(state_));
    line_.put_flash(FLASH_TEXT(" moving=")).put_unsigned(moving() ? 1 : 0);
    line_.put_flash(FLASH_TEXT(" attached=")).put_unsigned(attached_);
    line_.put_flash(FLASH_TEXT(" session=")).put_unsigned(session_ ? 1 : 0);
    const int32_t values_u[kGaitFieldCount] = {gait_.alpha_udeg, gait_.beta_udeg,
                                               gait_.omega_urad_s, gait_.offset_udeg};
    for (uint8_t i = 0; i < kGaitFieldCount; ++i) {
        line_.put(' ').put(gait_field(i).name).put('=').put_micro(values_u[i]);
    }
    line_.put_flash(FLASH_TEXT(" boot=")).put_unsigned(boot_id_);
    line_.put_flash(FLASH_TEXT(" frame=")).put_unsigned(frame_.number);
}

void Controller::put_counters() {
    line_.put_flash(FLASH_TEXT("counters:"));
#define FIRMWARE_PUT_COUNTER(name) \
    line_.put_flash(FLASH_TEXT(" " #name "=")).put_unsigned(counters_.name);
    FIRMWARE_COUNTERS(FIRMWARE_PUT_COUNTER)
#undef FIRMWARE_PUT_COUNTER
    line_.put_flash(FLASH_TEXT(" rxfull=")).put_unsigned(input_.overflow_count());
}

void Controller::put_timing() {
    line_.put_flash(FLASH_TEXT("timing: overruns=")).put_unsigned(counters_.overruns);
    line_.put_flash(FLASH_TEXT(" clipped=")).put_unsigned(counters_.clipped);
    line_.put_flash(FLASH_TEXT(" late_us=")).put_unsigned(counters_.late_us);
    line_.put_flash(FLASH_TEXT(" longest_pass_us=")).put_unsigned(counters_.longest_pass_us);
    line_.put_flash(FLASH_TEXT(" stack=")).put_unsigned(hardware_.unused_ram());
}

void Controller::put_field(const Field& field, int32_t value_u) {
    line_.put_flash(FLASH_TEXT("set: "))
        .put(field.name)
        .put_flash(FLASH_TEXT(" value="))
        .put_micro(value_u);
    line_.put_flash(FLASH_TEXT(" low="))
        .put_micro(field.low_u)
        .put_flash(FLASH_TEXT(" high="))
        .put_micro(field.high_u);
    line_.put_flash(FLASH_TEXT(" unit=")).put(field.unit);
}

void Controller::put_servo(uint8_t joint) {
    line_.put_flash(FLASH_TEXT("trim: #")).put_unsigned(joint + 1U);
    for (uint8_t f = 0; f < kTrimFieldCount; ++f) {
        line_.put(' ').put(trim_field(f).name).put('=').put_micro(settings_.trim_u[joint][f]);
    }
}

}  // namespace firmware
