// The joints' work over the pieces of a cycle: the integral of each joint's positive power.
#pragma once

#include <vector>

#include "periodic/cycle_map.hpp"
#include "periodic/pieces/event_finder.hpp"
#include "periodic/pieces/sliding_piece.hpp"

namespace serpenoid {

class WorkMeter {
  public:
    WorkMeter(const Robot& robot, const Gait& gait, SlidingPiece& piece, const EventFinder& events);

    // `speed_aim`: unit of the margins of wheels that slide, m/s.
    void start(bool active, double tolerance, double speed_aim);

    // Add the first x of the piece, which is h long. `skipped` of phase before it went by in event
    // steps.
    void add(const SlidingMode& mode, double h, double x, double skipped);

    // Wheels whose sign changed at an event.
    void changed(int wheel) { fresh_[wheel] = 1; }

    const JointWork& work() const { return work_; }

  private:
    void add_doubt(const SlidingMode& mode, double h, double x);

    double omega_;
    double lever_;  // how far a joint moves against a wheel's force, m a rad of phase
    SlidingPiece& piece_;
    const EventFinder& events_;
    std::vector<Lanes> torque_;
    std::vector<Lanes> rate_;
    std::vector<char> fresh_;  // wheels whose sliding has just begun
    JointWork work_;
    double speed_aim_ = 0;
    double max_block_ = 0;  // rad, of five samples
    bool active_ = false;
};

}  // namespace serpenoid
