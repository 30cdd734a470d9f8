// The firmware's virtual board with any number of joints, behind one interface.
//
// The number of joints is fixed when the firmware is compiled. So it is compiled once for each
// number, in a namespace of its own (see CMakeLists.txt).
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace serpenoid {

class AnyBoard {
  public:
    virtual ~AnyBoard() = default;
    // reset: `power`, `brownout`, `external` or `watchdog`; anything else throws.
    virtual void boot(const std::string& reset, std::uint32_t first_frame) = 0;
    virtual void run(std::uint64_t duration_us) = 0;
    virtual void stall(std::uint64_t duration_us) = 0;
    virtual void put(const std::string& bytes) = 0;
    virtual std::string take() = 0;
    virtual std::vector<std::uint8_t>& eeprom() = 0;

    virtual std::uint64_t now_us() const = 0;
    virtual std::string state() const = 0;
    virtual std::uint32_t frame() const = 0;
    virtual std::uint16_t boot_id() const = 0;
    virtual bool session() const = 0;
    virtual std::vector<std::pair<std::string, unsigned>> counters() const = 0;
    virtual std::vector<double> setpoints_rad() const = 0;
    virtual std::vector<int> pulses_us() const = 0;
};

constexpr int kFewestJoints = 2, kMostJoints = 12;

// Throws std::invalid_argument for a number of joints that no board has.
std::unique_ptr<AnyBoard> make_board(int joints, std::uint64_t start_us);

}  // namespace serpenoid
