// Construction, start and readings of the board of board.hpp.
#include "board/board.hpp"

#include <stdexcept>

#include "gait.h"

namespace firmware {
thread_local uint8_t joint_count = SERPENOID_JOINTS;
}

namespace serpenoid {

Board::Board(std::uint64_t start_us, int joints)
    : joints_(static_cast<std::uint8_t>(joints)), board_(start_us) {
    if (joints >= 2 && joints <= firmware::kMaxJoints) return;
    throw std::invalid_argument("joints is " + std::to_string(joints) + "; a board has 2 to " +
                                std::to_string(firmware::kMaxJoints));
}

firmware::VirtualBoard& Board::activate() {
    firmware::joint_count = joints_;
    return board_;
}

void Board::boot(const std::string& reset, std::uint32_t first_frame) {
    using firmware::Reset;
    for (const Reset r : {Reset::Power, Reset::Brownout, Reset::External, Reset::Watchdog})
        if (reset == firmware::reset_name(r)) return activate().boot(r, first_frame);
    throw std::invalid_argument("reset is '" + reset +
                                "'; it must be power, brownout, external or watchdog");
}

std::vector<double> Board::setpoints_rad() const {
    const std::int16_t* const q14 = board_.controller().motion().setpoints_q14();
    std::vector<double> angles;
    for (int i = 0; i < joints_; ++i) angles.push_back(q14[i] / 16384.0);
    return angles;
}

std::vector<int> Board::pulses_us() const {
    std::vector<int> pulses;
    for (std::uint8_t i = 0; i < joints_; ++i) pulses.push_back(board_.servo_us(i));
    return pulses;
}

}  // namespace serpenoid
