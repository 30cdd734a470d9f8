// The periodic state of a map at a sequence of tighter tolerances (levels), with error estimates
// from the changes between levels.
#pragma once

#include <optional>
#include <vector>

#include "periodic/fixed_point.hpp"
#include "periodic/periodic_state.hpp"

namespace serpenoid {

class Refinement {
  public:
    Refinement(CycleMap& map, FixedPoint& point, const SteadyOptions& options)
        : map_(map), point_(point), options_(options) {}

    // Tighten the tolerance until a state is accepted. If none is, return the best one.
    SteadyState refine(double first_tolerance, const Acceptance& accepted);

  private:
    // Changes from one level to the next.
    struct Change {
        double speed = 0, power = 0, turn = 0, log_largest_multiplier = 0;
    };
    FixedPoint::Ended level(double tolerance, SteadyState& next);
    std::optional<SteadyState> report(const Orbit& orbit, double tolerance) const;
    void state_errors(const Orbit& orbit, double tolerance, SteadyState& next);
    void add_positive(const JointWork& work, double remainder, SteadyState& next);

    CycleMap& map_;
    FixedPoint& point_;
    SteadyOptions options_;
    SteadyState coarse_;              // state of the last level
    Change last_change_;              // change of that level from the one before it
    std::vector<double> positive_{};  // positive work of every joint at that level, J
    Vec3 last_start_{};               // start of that level
    bool first_ = true;
};

}  // namespace serpenoid
