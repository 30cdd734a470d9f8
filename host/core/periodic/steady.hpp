// Periodic state on any ground: Newton's method (fixed_point.hpp) on the map of a cycle, at ever
// tighter tolerances until the errors are small enough.
//
// At a tolerance Newton's method runs until its next step is so small that the derivatives stand
// for it. The map goes by smooth pieces (pieces/sliding_cycle.hpp). Where these run out the best
// state found is the answer, with its errors.
#pragma once

#include <optional>

#include "periodic/fixed_point.hpp"
#include "periodic/periodic_state.hpp"

namespace serpenoid {

// Solves for one shape and any number of rates; each starts from the one before.
class SteadyByPieces {
  public:
    SteadyByPieces(const Robot& robot, const Ground& ground, const Gait& gait)
        : robot_(robot), ground_(ground), gait_(gait) {}
    // Starts from the last state of a neighbour.
    SteadyByPieces(const Robot& robot, const Ground& ground, const Gait& gait,
                   const SteadyByPieces& neighbour)
        : robot_(robot), ground_(ground), gait_(gait), last_(neighbour.last_) {}

    // `start`: velocities in the body frame at phase 0 from which the search begins.
    SteadyState solve(double omega, const SteadyOptions& options, const Vec3* start = nullptr);

  private:
    SteadyState at_rest(double omega, const SteadyOptions& options) const;
    void search_from_rest(CycleMap& map, FixedPoint& point, const Acceptance& accepted,
                          const SteadyOptions& options, SteadyState& best) const;

    Robot robot_;
    Ground ground_;
    Gait gait_;
    bool promising_ = false;    // starts are so good that the first map may do
    std::optional<Vec3> last_;  // start of the last rate's state, where it was found
};

}  // namespace serpenoid
