// The firmware's virtual board, with a number of joints for each board.
//
// The firmware is compiled once for the host. It reads the number of joints from a variable of the
// thread, which `activate` sets before the board runs.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "virtual_board.hpp"

namespace serpenoid {

class Board {
  public:
    // Throws std::invalid_argument if a board cannot have this number of joints.
    Board(std::uint64_t start_us, int joints);

    // reset: `power`, `brownout`, `external` or `watchdog`; anything else throws.
    void boot(const std::string& reset, std::uint32_t first_frame);
    // The board, ready to run in this thread; and the same board for reading only.
    firmware::VirtualBoard& activate();
    const firmware::VirtualBoard& view() const { return board_; }
    std::vector<double> setpoints_rad() const;
    std::vector<int> pulses_us() const;

  private:
    std::uint8_t joints_;
    firmware::VirtualBoard board_;
};

}  // namespace serpenoid
