// The map of a cycle on dry ground, with its exact derivative: smooth pieces (sliding_piece.hpp)
// from one event to the next.
//
// An event (event_finder.hpp) ends a mode, and a very short implicit step (event_step.hpp) finds
// the next one. Where sliding ends the rate of p jumps from f- to f+, and a trajectory that starts
// beside this one gets there a little earlier or later: the derivative is multiplied by the
// saltation matrix 1 + (f+ - f-) grad(v) / v', v being the speed that reaches zero. Where a wheel
// breaks loose the rate is continuous, and the derivative stays as it is.
#pragma once

#include <vector>

#include "periodic/cycle_map.hpp"
#include "periodic/pieces/event_finder.hpp"
#include "periodic/pieces/event_step.hpp"
#include "periodic/pieces/sliding_piece.hpp"
#include "periodic/pieces/work_meter.hpp"

namespace serpenoid {

class SlidingCycle : public CycleMap {
  public:
    SlidingCycle(const Robot& robot, const Ground& ground, const Gait& gait, long most_pieces);

    std::optional<CycleEnd> follow(const Vec3& p, const Following& how) override;
    bool smooth() const override { return !piece_.has_modes(); }

  private:
    // A saltation waits for the rate after the event.
    struct Saltation {
        bool waits = false;
        double slope = 0;
        Vec3 rate{}, gradient{};  // of p before the event; of the speed that reached zero, by p
    };
    void aim(double tolerance);
    bool advance();
    enum class Piece { done, shorter, broken };
    Piece solve_piece(double h);
    bool change_mode(const ModeEvent& event);
    bool event_step(const ModeEvent& event);
    void note_changes();
    void await_saltation(const ModeEvent& event);
    void saltate(const Vec3& rate_after);
    std::pair<double, Vec3> dissipation(const SlidingPiece::Node& node, const Vec3& u) const;
    void accumulate(double h, double x);

    double omega_, least_dry_;
    SlidingPiece piece_;
    EventFinder events_;
    EventStep event_step_;
    WorkMeter meter_;
    SlidingMode mode_, before_;  // now, and before an event
    // of the cycle that is followed
    CycleState now_;
    Saltation saltation_;
    bool simultaneous_ = false;
    double tau_ = 0, tolerance_ = 0, spin_ = 0, growth_ = 1;
    double piece_length_ = 0.3, longest_piece_ = 0.8, step_length_ = 0, shortest_step_ = 0,
           longest_step_ = 0, skipped_ = 0;
    long pieces_ = 0, most_pieces_;
};

}  // namespace serpenoid
