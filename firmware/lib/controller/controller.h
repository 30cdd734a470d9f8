// The state machine between the serial line and the servos: sessions, commands, frames, silence,
// telemetry.
#pragma once

#include "command.h"
#include "fields.h"
#include "hardware.h"
#include "line_reader.h"
#include "motion.h"
#include "progmem.h"
#include "settings.h"
#include "store.h"
#include "telemetry.h"

namespace firmware {

extern const char kVersion[];     // version of the firmware, in flash
extern const char kWhyCommand[];  // reason of a change of state by a command, in flash
const uint8_t kProtocol = 5;

enum class State : uint8_t { Idle, Pose, Gait, Hold, Safing, Safe };
enum class Reset : uint8_t { Power, Brownout, External, Watchdog, Unknown };

// Facts about this start that the board passes to its controller.
struct Start {
    const char* board;  // name, in RAM
    Reset reset;
    uint32_t first_frame;  // 0 on a board; tests start just before the number overflows
};

// Counters of the line `counters:`; their names are those on the wire.
#define FIRMWARE_COUNTERS(X) X(good) X(damaged) X(lost) X(dropped)

// 16-bit counters, which stay at 65535 instead of overflowing, and two maxima.
struct Counters {
#define FIRMWARE_COUNTER(name) uint16_t name;
    FIRMWARE_COUNTERS(FIRMWARE_COUNTER)
#undef FIRMWARE_COUNTER
    uint16_t overruns, clipped;
    uint32_t late_us, longest_pass_us;  // largest values since the start
};

inline void count(uint16_t& counter, uint16_t events = 1) {
    counter = counter > 65535U - events ? 65535 : static_cast<uint16_t>(counter + events);
}

// The variables of a controller, in one struct that starts as zero: on an AVR one loop clears it,
// which takes less flash than an instruction for each variable.
struct Memory {
    // The kind of line that a verdict answers. The characters of all but Numbered go on the wire.
    enum class Source : char { Numbered = '#', Typed = '-', StopKey = '!', Damaged = '?' };
    struct Tag {
        Source source;
        uint16_t number;
    };
    enum class Report : uint8_t { None, Status, Help, Set, Trim };

    Settings settings_;
    Trim trim_[kMaxJoints];
    Gait gait_;
    Frame frame_;
    Counters counters_;
    Start start_;
    uint32_t due_us_;
    uint32_t silent_frames_;  // since the last good line
    uint16_t telemetry_wait_;
    uint16_t boot_id_, last_number_;
    State state_;
    LoadResult load_result_;
    Tag tag_, store_tag_;  // tags of the last line, and of the last line that saves or loads
    Error last_error_;     // verdict on last_number_
    LineReader::Event waiting_;
    Report report_;
    uint8_t report_row_;
    uint8_t telemetry_sent_while_waiting_;  // telemetry lines since a line waits for its answer
    uint8_t key_answers_due_, word_answers_due_;  // unanswered stops: by `!`, by `stop`
    uint8_t attached_, attach_wait_;  // powered servos, from the tail; frames until the next one
    bool session_;
};

class Controller : private Memory {
  public:
    explicit Controller(Hardware& hardware);

    // Call once, after reset.
    OWN_FRAME void begin(const Start& start);
    // Call as often as possible. Runs a frame if one is due, then handles some input.
    OWN_FRAME void poll();

    // Time until the next frame.
    uint32_t spare_us();
    uint16_t frame_us() const { return motion_.frame_us(); }
    // Whether no answer and no report is pending.
    bool quiet() const;
    bool uses_eeprom() const { return store_.busy(); }

    State state() const { return state_; }
    const Counters& counters() const { return counters_; }
    const Settings& settings() const { return settings_; }
    uint32_t frame_number() const { return frame_.number; }
    uint16_t boot_id() const { return boot_id_; }
    bool session() const { return session_; }
    const Motion& motion() const { return motion_; }

  private:
    // A line is handled only if its longest answer fits into the output queue.
    static const uint8_t kMaxAnswerBytes = 165;
    // The longest telemetry line, for which the queue must have room whenever a frame is due.
    static uint16_t max_telemetry_bytes() {
        return static_cast<uint16_t>(95 + 18 * joint_count + kOwnSensorRoom);
    }
    static const uint8_t kByteUs = 40;
    // Least time between two telemetry lines so that an answer fits between them, if all lines have
    // their greatest length: the time on the wire, and the time from the beginning of a frame to
    // the end of its line (3.3 ms with 5 joints, 4.8 ms with 8, measured with the PCA9685).
    static uint16_t telemetry_us() {
        return static_cast<uint16_t>(
            kByteUs * (2 * max_telemetry_bytes() + kMaxAnswerBytes + 1 - Output::size()) +
            400 * joint_count);
    }
    // The time of a frame in which nothing is sent.
    static uint16_t busy_us() { return static_cast<uint16_t>(150 * joint_count); }
    // Servos are attached one after the other, because each starts with a jerk; the time between.
    static const uint32_t kAttachUs = 100000;

    // controller.cpp: time
    void choose_frame();
    OWN_FRAME void frame(uint32_t now_us, uint32_t late_us);
    OWN_FRAME void move(uint16_t frames);
    void send_pulses();
    OWN_FRAME void attach_next();
    bool attaching() const;
    void watch_silence(uint16_t frames);
    void watch_limp();
    OWN_FRAME void send_telemetry(uint16_t frames);
    void become(State state, const char* why);
    bool moving() const;

    // obey.cpp: commands
    OWN_FRAME Refusal obey(const Command& command);
    Error motion_obstacle();
    OWN_FRAME Refusal start_gait(const Command& command);
    OWN_FRAME Refusal start_pose(const Command& command);
    OWN_FRAME Refusal change_setting(const Command& command);
    Field setting(uint8_t index) const;
    OWN_FRAME Refusal change_trim(const Command& command);
    Refusal begin_save(const Command& command);
    Refusal replace_settings(bool saved);
    OWN_FRAME Refusal within_joint_limits(uint8_t joint, int32_t angle_udeg) const;
    void stop(const char* why);
    void go_idle(const char* why);
    void enter_powered(State state);
    OWN_FRAME void configure();
    uint8_t min_telemetry_frames() const;

    // dialogue.cpp: lines
    OWN_FRAME void receive();
    void obey_stops();
    bool may_answer();
    void answer_stops();
    void accept_waiting();
    OWN_FRAME void accept_line();
    OWN_FRAME void accept_body(const Envelope& envelope);
    bool in_order(const Envelope& envelope);
    void refuse_damaged(Error error);
    OWN_FRAME void verdict(const Tag& tag, const Refusal& refusal, bool repeated = false);
    OWN_FRAME void work_on_store();
    void send();

    // report.cpp: data lines
    void greet();
    OWN_FRAME void next_report_line();
    uint8_t report_rows() const;
    void put_report_line(uint8_t row);
    OWN_FRAME void put_status();
    OWN_FRAME void put_counters();
    void put_timing();
    void put_field(const Field& field, int32_t value_u);
    OWN_FRAME void put_servo(uint8_t joint);

    Hardware& hardware_;
    Store store_;
    Input& input_;
    Output& line_;
    Motion motion_;
    LineReader reader_;
};

// Names on the wire, in flash.
const char* state_name(State state);
const char* reset_name(Reset reset);
const char* load_result_name(LoadResult result);

}  // namespace firmware
