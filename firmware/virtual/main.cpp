// A board to type at, in real time: `pio run -e native -t exec`, then `help`; Ctrl-D ends it.
#include <chrono>
#include <cstdio>
#include <iostream>
#include <string>

#include "controller.h"  // PlatformIO looks for libraries in this file alone
#include "virtual_board.hpp"

namespace {

// Typed lines come with a person's pauses: each is answered within a tenth of a second.
void answer(firmware::VirtualBoard& board, const std::string& line) {
    board.put(line + "\n");
    board.run(100000);
    std::fputs(board.take().c_str(), stdout);
}

}  // namespace

#ifndef PIO_UNIT_TESTING
int main() {
    firmware::VirtualBoard board;
    board.boot(firmware::Reset::Power);
    answer(board, "set every 50");
    const auto begun = std::chrono::steady_clock::now();
    for (std::string line; std::getline(std::cin, line);) {
        const auto passed = std::chrono::steady_clock::now() - begun;
        const auto now_us = std::chrono::duration_cast<std::chrono::microseconds>(passed).count();
        const uint64_t behind_us = static_cast<uint64_t>(now_us);
        if (behind_us > board.now_us()) board.run(behind_us - board.now_us());
        answer(board, line);
    }
    return 0;
}
#endif
