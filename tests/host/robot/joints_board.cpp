// The virtual board for as many joints as SERPENOID_JOINTS says, as a C library for Python.
#include "virtual_board.hpp"

using firmware::VirtualBoard;

extern "C" {

VirtualBoard* board_new() {
    VirtualBoard* board = new VirtualBoard;
    board->boot(firmware::Reset::External);
    return board;
}

void board_delete(VirtualBoard* board) { delete board; }

void board_run(VirtualBoard* board, double seconds) {
    board->run(static_cast<uint64_t>(seconds * 1e6 + 0.5));
}

void board_write(VirtualBoard* board, const char* bytes, size_t length) {
    board->put(std::string(bytes, length));
}

size_t board_read(VirtualBoard* board, char* bytes, size_t most) {
    const std::string said = board->take();
    if (said.size() > most) throw std::length_error("more was said than there is room for");
    said.copy(bytes, said.size());
    return said.size();
}

double board_time_s(const VirtualBoard* board) {
    return static_cast<double>(board->now_us()) * 1e-6;
}

}  // extern "C"
