// Explicit or implicit steps, whichever take a run further in the same time.
#pragma once

#include <algorithm>
#include <vector>

#include "methods/adaptive/dop853.hpp"
#include "methods/adaptive/radau.hpp"
#include "methods/method.hpp"
#include "scene/system.hpp"

namespace serpenoid {

// Where ringing or a fast decay swings by more than the tolerance it has to be followed: dop853
// does that at the least cost, with errors far below the tolerance. Where it swings by less,
// implicit steps pass over it. From time to time an implicit step is tried, several times as long
// as an explicit one. It has to succeed at once; the run goes back to explicit steps before it
// would take implicit ones that do not pay.
class SwitchedSteps final : public Method {
  public:
    SwitchedSteps(System& system, const std::vector<double>& scale, double tolerance)
        : explicit_(system, scale, tolerance), implicit_(system, scale, tolerance, {}) {}

    void restart(double t, const double* y) override { active_->restart(t, y); }
    const char* step(double t_limit) override {
        if (active_ == &explicit_ && steps_ >= wait_)
            begin_implicit(kSwitching.paying_ratio * explicit_.next_step());
        ++steps_;
        const char* failure = active_->step(t_limit);
        if (!failure || shortest_ == 0) return failure;
        if (active_ == &explicit_) {
            begin_implicit(0);
        } else {
            wait_ = std::min(kSwitching.longest_wait, 2 * wait_);
            explicit_.restart(time(), state());
            active_ = &explicit_;
            steps_ = 0;
        }
        return step(t_limit);
    }
    double time() const override { return active_->time(); }
    const double* state() const override { return active_->state(); }
    int dense_order() const override { return active_->dense_order(); }
    void dense(double t, double* y) const override { active_->dense(t, y); }
    double local_error() const override { return active_->local_error(); }

  private:
    // Set on springs with 6, 24 and 50 links, k from 1e5 to 1e9, angles, tables of torques and
    // servos, tolerances 1e-6 and 1e-9, by processor time and by the error after a second.
    struct Switching {
        double paying_ratio;  // of an implicit to an explicit step of the same time
        int first_wait;       // explicit steps before a trial of an implicit one
        int longest_wait;     // the same later: each return to explicit steps doubles it
    };
    static constexpr Switching kSwitching{2, 12, 500};

    // Without a shortest step there is no way back: explicit steps have failed.
    void begin_implicit(double shortest) {
        implicit_.begin(time(), state(), 2 * kSwitching.paying_ratio * explicit_.next_step(),
                        shortest);
        active_ = &implicit_;
        shortest_ = shortest;
        steps_ = 0;
    }

    Dop853 explicit_;
    Radau implicit_;
    Method* active_ = &explicit_;
    int steps_ = 0, wait_ = kSwitching.first_wait;
    double shortest_ = HUGE_VAL;  // of implicit steps, s
};

}  // namespace serpenoid
