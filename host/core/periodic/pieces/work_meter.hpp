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

    void start(bool wanted, double tolerance);

    // Add the first x of the piece, which begins at tau and is h long. `skipped` of phase before it
    // went by in event steps.
    void add(const SlidingMode& mode, double tau, double h, double x, double skipped);

    // Wheels whose sign changed at an event.
    void changed(int wheel) { fresh_[wheel] = 1; }

    const JointWork& work() const { return work_; }

  private:
    void add_event_steps(double skipped);
    void add_part(double tau, double h, double from, double wide);
    void add_doubt(const SlidingMode& mode, double h, double x);

    double alpha_, omega_, reach_;
    std::vector<double> lag_;  // of every joint, rad
    SlidingPiece& piece_;
    const EventFinder& events_;
    std::vector<Lanes> torque_, rate_;
    std::vector<char> fresh_;  // wheels whose sliding has just begun
    JointWork work_;
    double longest_ = 0;  // part of a piece, rad
    bool wanted_ = false;
};

}  // namespace serpenoid
