// One very short implicit step at an event, without any mode: it finds the mode that follows.
//
// The step is one of implicit Euler, a convex problem (kinked_quadratic.hpp) whose solution says of
// every wheel whether it slides or sticks.
#pragma once

#include <vector>

#include "numerics/kinked_quadratic.hpp"
#include "periodic/cycle_map.hpp"
#include "periodic/pieces/event_finder.hpp"
#include "periodic/pieces/sliding_piece.hpp"

namespace serpenoid {

class EventStep {
  public:
    EventStep(const CycleMap& map, SlidingPiece& piece);

    // How much of the scales wheels at rest may be moved by at an event.
    void limit_correction(double max_correction) { max_correction_ = max_correction; }

    // Step from tau over dtau and set the mode there, after an event in the mode before. spin: of
    // the axes of x and y. False where the convex problem cycles. Nodes 0 and 1 of the piece are
    // then those of both ends.
    bool take(CycleState& state, double tau, double dtau, double spin, const SlidingMode& last_mode,
              const ModeEvent& event, SlidingMode& mode);

    void forget() { convex_.forget(); }  // the modes of the last step

  private:
    void set_kinks(double h, const SlidingMode& last_mode, const ModeEvent& event);
    bool solve(const Vec3& p, const Vec3& u0, double h);
    double dissipation(const Vec3& u) const;
    void set_mode(SlidingMode& mode) const;
    void put_at_rest(const SlidingMode& mode, CycleState& state) const;

    double omega_, nm_, max_correction_ = 0;
    Vec3 scale_;
    SlidingPiece& piece_;
    KinkedQuadratic3 convex_;
    std::vector<Kink> kinks_;
    std::vector<int> wheel_of_kink_;
    std::vector<double> apart_;      // by how much each kink is moved, below 1
    std::vector<double> direction_;  // of every wheel before the step, by its sign
};

}  // namespace serpenoid
