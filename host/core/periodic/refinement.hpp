// The periodic state of a map at ever tighter tolerances, with the errors that the levels show.
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

    // Tighten the tolerance until a state is accepted; the best state where none is.
    SteadyState refine(double first_tolerance, const Acceptance& accepted);

  private:
    // What changed from one level to the next.
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
    SteadyState coarse_;              // the level before
    Change last_change_;              // of that level from its own coarser one
    std::vector<double> positive_{};  // every joint's positive work of that level, J
    Vec3 last_start_{};               // and its start
    bool first_ = true;
};

}  // namespace serpenoid
