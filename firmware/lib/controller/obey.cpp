// The commands: the action of each one, and the states in which it is refused.
#include "controller.h"
#include "progmem.h"

namespace firmware {

const char kWhyCommand[] FLASH = "command";

Refusal Controller::obey(const Command& command) {
    switch (command.verb) {
        case Verb::Gait:
            return start_gait(command);
        case Verb::Pose:
            return start_pose(command);
        case Verb::Set:
            return change_setting(command);
        case Verb::Trim:
            return change_trim(command);
        case Verb::Save:
            return begin_save(command);
        case Verb::Load:
        case Verb::Defaults:
            return replace_settings(command.verb == Verb::Load);
        case Verb::Hello:
            greet();
            break;
        case Verb::Bye:
            session_ = false;
            break;
        case Verb::Help:
            report_ = Report::Help;
            break;
        case Verb::Status:
            report_ = Report::Status;
            break;
        case Verb::Stop:
            stop(kWhyCommand);
            break;
        case Verb::Idle:
            go_idle(kWhyCommand);
            break;
        case Verb::Ping:
            break;
    }
    return Refusal();
}

Refusal Controller::within_joint_limits(uint8_t joint, int32_t angle_udeg) const {
    const int32_t low = settings_.trim_u[joint][kLow], high = settings_.trim_u[joint][kHigh];
    if (angle_udeg >= low && angle_udeg <= high) return Refusal();
    const uint8_t number = static_cast<uint8_t>(joint + 1);
    char name[4] = {'j', static_cast<char>('0' + number), '\0', '\0'};
    if (number > 9) {
        name[1] = '1';
        name[2] = static_cast<char>('0' + number - 10);
    }
    return Refusal(Error::Range, name, angle_udeg, low, high);
}

// The error that forbids motion at present, or none.
Error Controller::motion_obstacle() {
    if (store_.busy()) return Error::Saving;
    return hardware_.output_answers() ? Error::None : Error::Output;
}

Refusal Controller::start_gait(const Command& command) {
    const Refusal obstacle(motion_obstacle());
    if (!obstacle.none()) return obstacle;
    const int32_t* u = command.value_u;
    for (uint8_t i = 0; i < joint_count; ++i) {
        Refusal refusal = within_joint_limits(i, u[kOffset] + u[kAlpha]);
        if (refusal.none()) refusal = within_joint_limits(i, u[kOffset] - u[kAlpha]);
        if (!refusal.none()) return refusal;
    }
    // alpha · omega in deg/s · 1e-6, from thousandths so that 32 bits hold it.
    const uint32_t speed_u =
        static_cast<uint32_t>(u[kAlpha] / 1000) * static_cast<uint32_t>(u[kOmega] / 1000);
    const int32_t max_u = settings_.value_u[kServoSpeed];
    if (speed_u > static_cast<uint32_t>(max_u)) {
        const int32_t shown_u =
            speed_u > 2147483647UL ? 2147483647L : static_cast<int32_t>(speed_u);
        return Refusal(Error::Speed, "value", shown_u, 0, max_u);
    }
    gait_ = Gait{u[kAlpha], u[kBeta], u[kOmega], u[kOffset]};
    motion_.gait(gait_);
    enter_powered(State::Gait);
    return Refusal();
}

Refusal Controller::start_pose(const Command& command) {
    const Refusal obstacle(motion_obstacle());
    if (!obstacle.none()) return obstacle;
    int32_t target_q30[kMaxJoints];
    for (uint8_t i = 0; i < joint_count; ++i) {
        const Refusal refusal = within_joint_limits(i, command.value_u[i]);
        if (!refusal.none()) return refusal;
        target_q30[i] = q30_from_udeg(command.value_u[i]);
    }
    motion_.pose(target_q30);
    enter_powered(State::Pose);
    return Refusal();
}

// Enter a state in which the servos have power. Limp servos are attached one after the other, at
// their last setpoints.
void Controller::enter_powered(State state) {
    if (state_ == State::Idle) {
        for (uint8_t i = 0; i < joint_count; ++i) trim_[i] = trim_of(settings_.trim_u[i]);
    }
    become(state, kWhyCommand);
}

void Controller::stop(const char* why) {
    if (state_ == State::Idle) return;
    motion_.freeze();
    become(State::Hold, why);
}

void Controller::go_idle(const char* why) {
    motion_.freeze();
    hardware_.detach();
    attached_ = attach_wait_ = 0;
    frame_.clipped = 0;
    for (int16_t& pulse : frame_.pulse_us) pulse = 0;
    become(State::Idle, why);
}

Refusal Controller::change_setting(const Command& command) {
    if (command.lists) {
        report_ = Report::Set;
        return Refusal();
    }
    if (store_.busy()) return Refusal(Error::Saving);
    const int32_t value_u = command.value_u[0];
    Field field = setting(command.field);
    if (command.field == kEvery && value_u != 0) field.low_u = min_telemetry_frames() * 1000000L;
    if (!in_range(field, value_u)) {
        return Refusal(Error::Range, field.name, value_u, field.low_u, field.high_u);
    }
    settings_.value_u[command.field] = value_u;
    if (command.field == kEvery) telemetry_wait_ = 0;
    configure();
    return Refusal();
}

// The field of a setting, with the limits of this board.
Field Controller::setting(uint8_t index) const {
    Field field = setting_field(index);
    if (index == kFrame) {
        field.low_u = hardware_.min_frame_us() * 1000L;
        field.high_u = field.low_u > kFrameUs * 1000L ? field.low_u : kFrameUs * 1000L;
    }
    return field;
}

Refusal Controller::change_trim(const Command& command) {
    if (command.lists) {
        report_ = Report::Trim;
        return Refusal();
    }
    if (store_.busy()) return Refusal(Error::Saving);
    if (moving()) return Refusal(Error::Motion);
    if (command.field != kCentre && state_ != State::Idle) return Refusal(Error::Attached);
    int32_t& value_u = settings_.trim_u[command.joint][command.field];
    const int32_t old_value_u = value_u;
    value_u = command.value_u[0];
    int32_t limit_us;
    if (!within_pulses(settings_.trim_u[command.joint], limit_us)) {
        value_u = old_value_u;
        return Refusal(Error::Range, "pulse_ms", limit_us * 1000, kMinPulseUs * 1000L,
                       kMaxPulseUs * 1000L);
    }
    configure();
    return Refusal();
}

// Least number of frames from one telemetry line to the next, so that answers fit between.
uint8_t Controller::min_telemetry_frames() const {
    const uint16_t usable_us = static_cast<uint16_t>(frame_us() - busy_us());
    return static_cast<uint8_t>((telemetry_us() + usable_us - 1) / usable_us);
}

void Controller::configure() {
    const int32_t min_u = min_telemetry_frames() * 1000000L;
    int32_t& every_u = settings_.value_u[kEvery];
    if (every_u != 0 && every_u < min_u) every_u = min_u;
    set_limits(motion_.limits(), settings_);
    motion_.limits_changed();
    if (state_ != State::Idle) return;
    motion_.freeze();
    for (uint8_t i = 0; i < joint_count; ++i) trim_[i] = trim_of(settings_.trim_u[i]);
}

Refusal Controller::begin_save(const Command& command) {
    if (store_.busy()) return Refusal(Error::Saving);
    if (moving()) return Refusal(Error::Motion);
    if (settings_.value_u[kSilence] == 0 && !command.unattended) return Refusal(Error::Unattended);
    store_.save(settings_);
    return Refusal();
}

// Replace all settings and trims by the saved ones, or by the defaults of the firmware.
Refusal Controller::replace_settings(bool saved) {
    if (store_.busy()) return Refusal(Error::Saving);
    if (state_ != State::Idle) return Refusal(Error::Attached);
    telemetry_wait_ = 0;
    if (saved) {
        store_.load(settings_);
    } else {
        set_defaults(settings_);
        configure();
    }
    return Refusal();
}

}  // namespace firmware
