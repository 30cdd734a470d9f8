// Newton's method for a motion that repeats: three unknowns, on any map of cycle_map.hpp.
#pragma once

#include "periodic/cycle_map.hpp"

namespace serpenoid {

// A start, what following from it gave, and the change that would make it repeat. States are over
// the scales of the map.
struct Orbit {
    Vec3 start{};
    CycleEnd end;       // of the motion from the start
    Vec3 residual{};    // mirror image of the end less the start
    Mat3 derivative{};  // M, of that image by the start
    Vec3 step{};        // (1 - M)^-1 residual: Newton's change of the start, not made in `end`

    Vec3 next_start() const { return {start[0] + step[0], start[1] + step[1], start[2] + step[2]}; }
    // A value at the end of the motion from next_start(), by its derivative.
    double extrapolate(double value, int row, const Vec3& scale) const;
    // How much a value at the end changes with the start, for a change of the size of the scales.
    double sensitivity(int row, const Vec3& scale) const;
    // How many times an error of the map moves its fixed point: the norm of (1 - M)^-1.
    double condition() const;
};

class FixedPoint {
  public:
    FixedPoint(CycleMap& map, bool promising) : promising_(promising), map_(map) {}

    enum class Ended { converged, stalled, broken };

    // Until the next step is at most `goal`; the orbit then has it, and the start is changed by it.
    Ended solve(double tolerance, double goal, bool work, Orbit& orbit);

    // Follow the motion until a cycle changes it by less than `settled`, or for so many cycles.
    // share: of the first cycle's change that is made. False where the map breaks off.
    bool follow_cycles(int max_cycles, double settled, double tolerance, double share = 1);

    Vec3 start{};
    bool start_solved = false;  // to a tolerance
    bool promising() const { return promising_; }

  private:
    bool evaluate(const Following& how, Orbit& orbit);
    bool step(const Orbit& orbit, double damping, Vec3& d) const;
    bool shorten(const Orbit& orbit, double max_size, Vec3& d) const;

    bool promising_;  // the start is so good that the first map may do
    CycleMap& map_;
};

}  // namespace serpenoid
