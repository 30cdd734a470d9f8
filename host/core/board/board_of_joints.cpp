// One virtual board of SERPENOID_JOINTS joints; compiled once for each number of joints.
#include <stdexcept>

#include "board/any_board.hpp"
#include "virtual_board.hpp"

#define JOINED(a, b) a##b
#define NAMED(a, b) JOINED(a, b)
#define MAKE_BOARD NAMED(make_board_of_, SERPENOID_JOINTS)

namespace serpenoid {
namespace {

class BoardOfJoints : public AnyBoard {
  public:
    explicit BoardOfJoints(std::uint64_t start_us) : board_(start_us) {}

    void boot(const std::string& reset, std::uint32_t first_frame) override {
        board_.boot(reset_named(reset), first_frame);
    }
    void run(std::uint64_t duration_us) override { board_.run(duration_us); }
    void stall(std::uint64_t duration_us) override { board_.stall(duration_us); }
    void put(const std::string& bytes) override { board_.put(bytes); }
    std::string take() override { return board_.take(); }
    std::vector<std::uint8_t>& eeprom() override { return board_.eeprom(); }

    std::uint64_t now_us() const override { return board_.now_us(); }
    std::string state() const override { return firmware::state_name(controller().state()); }
    std::uint32_t frame() const override { return controller().frame_number(); }
    std::uint16_t boot_id() const override { return controller().boot_id(); }
    bool session() const override { return controller().session(); }
    std::vector<std::pair<std::string, unsigned>> counters() const override {
        const firmware::Counters& c = controller().counters();
        return {{"good", c.good},       {"damaged", c.damaged},   {"lost", c.lost},
                {"dropped", c.dropped}, {"overruns", c.overruns}, {"clipped", c.clipped}};
    }
    std::vector<double> setpoints_rad() const override {
        const std::int16_t* const q14 = controller().motion().setpoints_q14();
        std::vector<double> angles;
        for (int i = 0; i < firmware::kJoints; ++i) angles.push_back(q14[i] / 16384.0);
        return angles;
    }
    std::vector<int> pulses_us() const override {
        std::vector<int> pulses;
        for (std::uint8_t i = 0; i < firmware::kJoints; ++i) pulses.push_back(board_.servo_us(i));
        return pulses;
    }

  private:
    static firmware::Reset reset_named(const std::string& name) {
        using firmware::Reset;
        for (const Reset r : {Reset::Power, Reset::Brownout, Reset::External, Reset::Watchdog})
            if (name == firmware::reset_name(r)) return r;
        throw std::invalid_argument("reset is '" + name +
                                    "'; it must be power, brownout, external or watchdog");
    }
    const firmware::Controller& controller() const { return board_.controller(); }

    firmware::VirtualBoard board_;
};

}  // namespace

std::unique_ptr<AnyBoard> MAKE_BOARD(std::uint64_t start_us) {
    return std::make_unique<BoardOfJoints>(start_us);
}

}  // namespace serpenoid
