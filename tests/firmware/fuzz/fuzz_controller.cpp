// libFuzzer target: any bytes to a whole board, at wire pace with pauses, and what must hold
// always.
//
// A byte of 0x80 or more is a pause of so many milliseconds less 0x80, or one bare good line that
// is sealed here, so that the fuzzer need not guess CRCs. A `!` before a pause that is long enough
// for all bytes on their way has stopped the robot, whatever stands before it.
#include <cmath>
#include <cstdlib>
#include <string>

#include "controller.h"
#include "lines.h"
#include "virtual_board.hpp"

using namespace firmware;

namespace {

const uint32_t kStoppedMs = 120;  // 2000 bytes on the wire and two frames
// 1000 deg/s, the fastest setting, for a frame of 20 ms, and what roundings may add.
const int32_t kFarthestStepQ14 = 5720 + 3;

void require(bool holds) {
    if (!holds) std::abort();
}

struct Watch {
    VirtualBoard board;
    int16_t before_q14[kJoints] = {};

    // Advance, and hold every frame against joint limits, pulse limits and the speed limit.
    void run(uint32_t ms) {
        for (uint32_t k = 0; k < ms; ++k) {
            const State state = board.controller().state();
            board.run(1000);
            // servos are attached one by one, and only while the board is not idle
            if (board.controller().state() == State::Idle) require(board.attached() == 0);
            for (uint8_t i = 0; i < kJoints; ++i) check_joint(i, state);
        }
    }
    bool stopped() const {
        const State state = board.controller().state();
        return state == State::Hold || state == State::Idle;
    }
    void check_joint(uint8_t i, State before) {
        const Settings& settings = board.controller().settings();
        const int16_t q14 = board.controller().motion().setpoints_q14()[i];
        const int32_t step = std::abs(static_cast<int32_t>(q14) - before_q14[i]);
        before_q14[i] = q14;
        // While idle, settings may be half loaded, and setpoints take up what they say at its end.
        if (before == State::Idle || board.controller().state() == State::Idle) return;
        const Trim trim = trim_of(settings.trim_u[i]);
        require(q14 >= trim.low_q14 && q14 <= trim.high_q14);
        require(step <= kFarthestStepQ14);
        if (i < board.attached()) {
            require(board.servo_us(i) >= kLeastPulseUs && board.servo_us(i) <= kMostPulseUs);
        }
    }
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    if (size > 2000) return 0;
    Watch watch;
    watch.board.boot(Reset::Power);
    std::string line;
    uint16_t number = 0;
    bool key = false;  // the last byte was a `!`
    for (size_t i = 0; i < size; ++i) {
        const char byte = static_cast<char>(data[i]);
        line += byte;
        if (data[i] == 0x01) {  // seal what has come since the last line as a good numbered line
            line.erase(line.size() - 1);
            std::string body = "#" + std::to_string(++number) + " ";
            for (char c : line) {
                if (c >= 0x20 && c < 0x7F && body.size() < 70) body += c;
            }
            watch.board.put("\n" + sealed(body));
            line.clear();
            watch.run(10);
        } else if (data[i] >= 0x80) {
            const uint32_t pause_ms = data[i] - 0x80u;
            watch.run(pause_ms);
            if (key && pause_ms >= kStoppedMs) require(watch.stopped());
        } else {
            watch.board.put(std::string(1, byte));
            if (byte == '\n') line.clear();
        }
        key = data[i] == '!';
    }
    watch.run(40);
    watch.board.put("\n!\n");  // a stop always works
    watch.run(120);
    require(watch.stopped());
    return 0;
}
