// libFuzzer target: any bytes to a whole board, at wire pace with pauses: no undefined behaviour,
// and a stop always works. What joints may do is held in test_any_bytes_in_python.py.
//
// A byte of 0x80 or more is a pause of so many milliseconds less 0x80, or one bare good line that
// is sealed here, so that the fuzzer need not guess CRCs. A `!` before a pause that is long enough
// for all bytes on their way has stopped the robot, whatever stands before it.
#include <cstdlib>
#include <string>

#include "controller.h"
#include "lines.h"
#include "virtual_board.hpp"

using namespace firmware;

namespace {

const uint32_t kStoppedMs = 120;  // 2000 bytes on the wire and two frames

void require(bool holds) {
    if (!holds) std::abort();
}

struct Watch {
    VirtualBoard board;

    void run(uint32_t ms) {
        for (uint32_t k = 0; k < ms; ++k) {
            board.run(1000);
            // servos are attached one by one, and only while the board is not idle
            if (board.controller().state() == State::Idle) require(board.attached() == 0);
        }
    }
    bool stopped() const {
        const State state = board.controller().state();
        return state == State::Hold || state == State::Idle;
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
            watch.board.send_to_board("\n" + sealed(body));
            line.clear();
            watch.run(10);
        } else if (data[i] >= 0x80) {
            const uint32_t pause_ms = data[i] - 0x80u;
            watch.run(pause_ms);
            if (key && pause_ms >= kStoppedMs) require(watch.stopped());
        } else {
            watch.board.send_to_board(std::string(1, byte));
            if (byte == '\n') line.clear();
        }
        key = data[i] == '!';
    }
    watch.run(40);
    watch.board.send_to_board("\n!\n");  // a stop always works
    watch.run(120);
    require(watch.stopped());
    return 0;
}
