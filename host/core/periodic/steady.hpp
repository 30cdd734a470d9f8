// Periodic state on any ground: Newton's method (fixed_point.hpp) on the map of a cycle, at ever
// tighter tolerances until the errors are small enough.
//
// At a tolerance Newton's method runs until its next step is so small that the derivatives stand
// for it. The map goes by smooth pieces (pieces/sliding_cycle.hpp). Where these run out the best
// state found is the answer, with its errors.
#pragma once

#include <vector>

#include "periodic/fixed_point.hpp"
#include "periodic/periodic_state.hpp"

namespace serpenoid {

// Solves for one shape and any number of rates; each starts from the ones before.
class SteadyByPieces {
  public:
    SteadyByPieces(const Robot& robot, const Ground& ground, const Gait& gait)
        : robot_(robot), ground_(ground), gait_(gait) {}
    // Starts from the last state of a neighbour.
    SteadyByPieces(const Robot& robot, const Ground& ground, const Gait& gait,
                   const SteadyByPieces& neighbour)
        : robot_(robot), ground_(ground), gait_(gait), solutions_(neighbour.solutions_) {}

    // `start`: velocities in the body frame at phase 0 from which the search begins.
    SteadyState solve(double omega, const SteadyOptions& options, const Vec3* start = nullptr);

  private:
    struct Solution {  // of an earlier rate
        double omega;
        Vec3 start;
    };
    SteadyState at_rest(double omega, const SteadyOptions& options) const;
    void search_from_rest(CycleMap& map, FixedPoint& point, const Acceptance& accepted,
                          const SteadyOptions& options, SteadyState& best) const;
    Vec3 guess(double omega) const;
    void remember(double omega, const Vec3& start, bool converged);

    Robot robot_;
    Ground ground_;
    Gait gait_;
    bool promising_ = false;           // guesses are so good that the first map may do
    std::vector<Solution> solutions_;  // of up to two rates, the last one last
};

}  // namespace serpenoid
