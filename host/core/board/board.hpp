// The firmware's virtual board with a number of joints of its own.
//
// The firmware is compiled once for the host and asks for the number of joints of the board that
// runs in the thread: each way into the board sets it first.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "virtual_board.hpp"

namespace serpenoid {

class Board {
  public:
    // Throws std::invalid_argument for a number of joints that no board has.
    Board(std::uint64_t start_us, int joints);

    // reset: `power`, `brownout`, `external` or `watchdog`; anything else throws.
    void boot(const std::string& reset, std::uint32_t first_frame);
    // The board, to let its time pass; and to look at.
    firmware::VirtualBoard& enter();
    const firmware::VirtualBoard& view() const { return board_; }
    std::vector<double> setpoints_rad() const;
    std::vector<int> pulses_us() const;

  private:
    std::uint8_t joints_;
    firmware::VirtualBoard board_;
};

}  // namespace serpenoid
