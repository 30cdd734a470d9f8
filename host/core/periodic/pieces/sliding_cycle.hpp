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

// How a cycle is followed at a tolerance, a part of the scales of p.
struct CycleTolerances {
    double speed;          // m/s beyond rest, at which an event of a sliding wheel is aimed: far
                           // less than the tolerance, but more than rounding
    double force;          // over its bound, the same of a wheel at rest: forces are less accurate
    double correction;     // of the scales: more is not what an event step leaves, but a mistake
    double longest_piece;  // rad: beyond it Newton's method seldom converges
    double longest_step;   // rad, of an event step, which is of first order
    double shortest_step;  // rad: dry friction stops a wheel that missed its event within it
    double newton_step;  // of the scales, the last one on a piece; on smooth ground derivatives are
                         // to be as good as the motion, and they miss that step
};

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
    CycleTolerances tolerances_of(double tolerance) const;
    bool advance();
    enum class Piece { done, shorter, broken };
    Piece solve_piece(double h);
    bool change_mode(const ModeEvent& event);
    bool event_step(const ModeEvent& event);
    void note_changes();
    void apply_saltation(const Vec3& rate_after);
    std::pair<double, Vec3> dissipation(const SlidingPiece::Node& node, const Vec3& u) const;
    void accumulate(double h, double x);

    double omega_, breakaway_force_;
    SlidingPiece piece_;
    EventFinder events_;
    EventStep event_step_;
    WorkMeter meter_;
    SlidingMode mode_, last_mode_;  // and before an event
    // of the cycle that is followed
    CycleState state_;
    CycleTolerances tolerances_;
    Saltation saltation_;
    bool simultaneous_ = false;
    double tau_ = 0, tolerance_ = 0, spin_ = 0, growth_ = 1;
    double piece_length_ = 0.3;  // rad, of the next piece
    double step_length_ = 0;     // rad, of the last event step; 0 after a long piece
    double skipped_ = 0;         // rad, by event steps since the last piece
    long pieces_ = 0, most_pieces_;
};

}  // namespace serpenoid
