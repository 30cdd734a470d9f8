// The periodic state of a map at ever tighter tolerances, with the errors that the levels show.
#pragma once

#include <vector>

#include "periodic/fixed_point.hpp"
#include "periodic/periodic_state.hpp"

namespace serpenoid {

// Tolerances, each a part of the one before.
struct Levels {
    double first, tighter = 0.05, last = 1e-13;
    // Newton's last step: exact derivatives stand for it, and miss its square. In tolerances, or
    // in their square root where that is longer.
    double goal = 60, root_goal = 0.7;
};

class Refinement {
  public:
    Refinement(CycleMap& map, FixedPoint& point, const SteadyOptions& options)
        : map_(map), point_(point), options_(options) {}

    // Tighten the tolerance until a state is accepted; the best state where none is.
    SteadyState refine(const Levels& levels, const Acceptance& accepted);

  private:
    FixedPoint::Ended level(double tolerance, const Levels& levels, SteadyState& next);
    SteadyState report(const Orbit& orbit, double tolerance) const;
    void bound(const Orbit& orbit, double tolerance, SteadyState& next);
    void add_positive(const JointWork& work, double mismatch, SteadyState& next);

    CycleMap& map_;
    FixedPoint& point_;
    SteadyOptions options_;
    SteadyState coarse_;              // the level before
    LevelChange before_;              // and how it differed from its own coarser one
    std::vector<double> positive_{};  // and every joint's positive work
    Vec3 z_{};                        // and its start
    bool first_ = true;
};

}  // namespace serpenoid
