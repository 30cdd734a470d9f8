// The timing of the controller: frames, motion within a frame, telemetry, silence.
#include "controller.h"

#include "boot_counter.h"
#include "progmem.h"

namespace firmware {

const char kVersion[] FLASH = "0.3.0";

namespace {

const char kStateNames[][7] FLASH = {"idle", "pose", "gait", "hold", "safing", "safe"};
const char kResetNames[][9] FLASH = {"power", "brownout", "external", "watchdog", "unknown"};
const char kLoadResultNames[][9] FLASH = {"ok", "new", "older", "damaged", "migrated"};
const char kWhySilence[] FLASH = "silence";
const char kWhyArrived[] FLASH = "arrived";
const char kWhyLimp[] FLASH = "limp";
const char kWhyOutput[] FLASH = "output";

const uint16_t kCentreUsPerS = 200;  // rate at which a new centre is approached, µs of pulse a s

}  // namespace

const char* state_name(State state) { return kStateNames[static_cast<uint8_t>(state)]; }
const char* reset_name(Reset reset) { return kResetNames[static_cast<uint8_t>(reset)]; }
const char* load_result_name(LoadResult result) {
    return kLoadResultNames[static_cast<uint8_t>(result)];
}

// cppcheck-suppress uninitDerivedMemberVar  // Memory() sets them to zero
Controller::Controller(Hardware& hardware)
    : Memory(),
      hardware_(hardware),
      store_(hardware),
      input_(hardware.serial().input),
      line_(hardware.serial().output) {}

void Controller::begin(const Start& start) {
    start_ = start;
    boot_id_ = count_boot(hardware_);
    set_defaults(settings_);
    store_.load(settings_);
    while (store_.busy()) store_.step();
    load_result_ = store_.load_result();
    choose_frame();
    configure();
    frame_.number = start.first_frame - 1;
    frame_.state = state_name(state_);
    due_us_ = hardware_.micros() + frame_us();
    greet();
}

// Take the frame of the settings, or the shortest that the board can keep; until the next start.
void Controller::choose_frame() {
    int32_t& frame_setting_u = settings_.value_u[kFrame];
    const int32_t min_u = hardware_.min_frame_us() * 1000L;
    if (frame_setting_u < min_u) frame_setting_u = min_u;
    const uint16_t frame_us = static_cast<uint16_t>(frame_setting_u / 1000);
    motion_.limits().frame_us = frame_us;
    const int32_t khz = settings_.value_u[kOscillator] / 1000;
    hardware_.begin_frames(frame_us, static_cast<uint16_t>(khz));
}

void Controller::poll() {
    const uint32_t now_us = hardware_.micros();
    const uint32_t late_us = now_us - due_us_;
    if (static_cast<int32_t>(late_us) >= 0) frame(now_us, late_us);
    receive();
    accept_waiting();
    next_report_line();
    work_on_store();
    const uint32_t pass_us = hardware_.micros() - now_us;
    if (pass_us > counters_.longest_pass_us) counters_.longest_pass_us = pass_us;
}

uint32_t Controller::spare_us() {
    const uint32_t left_us = due_us_ - hardware_.micros();
    return static_cast<int32_t>(left_us) > 0 ? left_us : 0;
}

bool Controller::quiet() const {
    const bool waiting =
        waiting_ != LineReader::kNothing || key_answers_due_ != 0 || word_answers_due_ != 0;
    return report_ == Report::None && !waiting;
}

void Controller::frame(uint32_t now_us, uint32_t late_us) {
    uint16_t frames = 1;
    for (; late_us >= frame_us() * static_cast<uint32_t>(frames) && frames < 1000; ++frames) {
    }
    if (late_us > counters_.late_us) counters_.late_us = late_us;
    count(counters_.overruns, static_cast<uint16_t>(frames - 1));
    due_us_ += frames * static_cast<uint32_t>(frame_us());
    frame_.number += frames;
    frame_.board_us = now_us;
    frame_.late_us = late_us;
    watch_silence(frames);
    watch_limp();
    move(frames);
    frame_.exec_us = hardware_.micros() - now_us;
    send_telemetry(frames);
}

void Controller::move(uint16_t frames) {
    if (state_ == State::Idle) return;
    if (attaching()) {
        attach_next();
    } else {
        motion_.advance(frames);
    }
    frame_.clipped = motion_.clipped();
    if (frame_.clipped != 0) count(counters_.clipped);
    send_pulses();
    if (state_ == State::Safing && motion_.arrived()) become(State::Safe, kWhyArrived);
}

// Whether servos are still to be attached. Nothing moves before the last one is.
bool Controller::attaching() const {
    return attached_ < joint_count && (state_ == State::Pose || state_ == State::Gait);
}

void Controller::attach_next() {
    if (attach_wait_ > 0) {
        --attach_wait_;
        return;
    }
    const uint8_t joint = attached_++;
    attach_wait_ = static_cast<uint8_t>(kAttachUs / frame_us() - 1);
    hardware_.attach(joint, pulse_us(trim_[joint], motion_.setpoints_q14()[joint]));
}

void Controller::send_pulses() {
    const int16_t max_us = static_cast<int16_t>(frame_us() / (1000000 / kCentreUsPerS) + 1);
    frame_.phase = motion_.phase();
    for (uint8_t i = 0; i < joint_count; ++i) {
        const int16_t centre_us = static_cast<int16_t>(settings_.trim_u[i][kCentre] / 1000000);
        const int16_t gap_us = static_cast<int16_t>(centre_us - trim_[i].centre_us);
        const int16_t step_us = gap_us > max_us    ? max_us
                                : gap_us < -max_us ? static_cast<int16_t>(-max_us)
                                                   : gap_us;
        trim_[i].centre_us = static_cast<int16_t>(trim_[i].centre_us + step_us);
        frame_.setpoint_q14[i] = motion_.setpoints_q14()[i];
        frame_.pulse_us[i] = i < attached_ ? pulse_us(trim_[i], frame_.setpoint_q14[i]) : 0;
    }
    hardware_.pulses(frame_.pulse_us, frame_.board_us - frame_.late_us);
    if (!hardware_.output_answers()) go_idle(kWhyOutput);
}

bool Controller::moving() const {
    const bool may_move = state_ == State::Gait || state_ == State::Pose || state_ == State::Safing;
    return may_move && (attaching() || !motion_.arrived());
}

void Controller::watch_silence(uint16_t frames) {
    const uint32_t limit = static_cast<uint32_t>(settings_.value_u[kSilence]) / frame_us();
    if (silent_frames_ < 0xFFFF0000UL) silent_frames_ += frames;
    if (limit == 0 || silent_frames_ < limit) return;
    if (!moving() || state_ == State::Safing) return;
    if (attaching()) return go_idle(kWhySilence);  // nothing has moved yet
    const int32_t straight_q30[kMaxJoints] = {};
    motion_.pose(straight_q30);
    become(State::Safing, kWhySilence);
}

// Release the servos of a robot that stands still, once its host has been silent for long.
void Controller::watch_limp() {
    const uint32_t limit = static_cast<uint32_t>(settings_.value_u[kLimp]) / frame_us();
    if (limit == 0 || silent_frames_ < limit || state_ == State::Idle || moving()) return;
    go_idle(kWhyLimp);
}

void Controller::become(State state, const char* why) {
    if (state == state_) return;
    state_ = state;
    frame_.state = state_name(state);
    line_.begin()
        .put_flash(FLASH_TEXT("state: "))
        .put_flash(frame_.state)
        .put_flash(FLASH_TEXT(" why="))
        .put_flash(why);
    send();
}

void Controller::send_telemetry(uint16_t frames) {
    const uint16_t period_frames = static_cast<uint16_t>(settings_.value_u[kEvery] / 1000000);
    if (period_frames == 0) return;
    if (telemetry_wait_ > frames) {
        telemetry_wait_ = static_cast<uint16_t>(telemetry_wait_ - frames);
        return;
    }
    telemetry_wait_ = period_frames;
    // While an answer waits, one telemetry line may be sent before it. Further ones are dropped, or
    // the answer might never be sent.
    telemetry_sent_while_waiting_ =
        quiet() ? 0 : static_cast<uint8_t>(telemetry_sent_while_waiting_ + 1);
    if (telemetry_sent_while_waiting_ > 1 || !write_telemetry(line_, frame_))
        count(counters_.dropped);
}

}  // namespace firmware
