// One very short step of implicit Euler at an event; its result is the mode after the event.
//
// The step minimises a convex function with kinks (kinked_quadratic.hpp). The minimum shows for
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

    // Largest correction of p, as a fraction of the scales, that brings stuck wheels to rest.
    void limit_correction(double max_correction) { max_correction_ = max_correction; }

    // Step from phase tau to tau + dtau, after an event in last_mode, and set the mode at the end.
    // spin: rotation of the axes of x and y per phase. Returns false if the convex solver cycles.
    // Afterwards nodes 0 and 1 of the piece are both ends of the step.
    bool take(CycleState& state, double tau, double dtau, double spin, const SlidingMode& last_mode,
              const ModeEvent& event, SlidingMode& mode);

    void forget() { convex_.forget(); }  // discard the modes of the last step

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
    std::vector<double> shift_;      // shift of each kink, 0 to 1
    std::vector<double> direction_;  // speed of every wheel before the step; its sign counts
};

}  // namespace serpenoid
