// From a number of joints to the board that was compiled for it.
#include <stdexcept>

#include "board/any_board.hpp"

#define EACH_NUMBER_OF_JOINTS(X) X(2) X(3) X(4) X(5) X(6) X(7) X(8) X(9) X(10) X(11) X(12)

namespace serpenoid {

#define DECLARE_MAKER(joints) std::unique_ptr<AnyBoard> make_board_of_##joints(std::uint64_t);
EACH_NUMBER_OF_JOINTS(DECLARE_MAKER)
#undef DECLARE_MAKER

std::unique_ptr<AnyBoard> make_board(int joints, std::uint64_t start_us) {
    switch (joints) {
#define CALL_MAKER(joints) \
    case joints:           \
        return make_board_of_##joints(start_us);
        EACH_NUMBER_OF_JOINTS(CALL_MAKER)
#undef CALL_MAKER
    }
    throw std::invalid_argument("joints is " + std::to_string(joints) + "; a board has " +
                                std::to_string(kFewestJoints) + " to " +
                                std::to_string(kMostJoints));
}

}  // namespace serpenoid
