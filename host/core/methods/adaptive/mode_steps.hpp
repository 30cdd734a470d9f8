// Motion in modes (wheels that rest or slide) by dop853: smooth steps from one mode's end to the
// next.
//
// A step that went beyond the end of a mode is right up to there: the end is found on its dense
// output, and the next step starts from it in the modes that follow.
#pragma once

#include <functional>
#include <vector>

#include "methods/adaptive/dop853.hpp"
#include "methods/method.hpp"
#include "scene/system.hpp"

namespace serpenoid {

class ModeSteps final : public Method {
  public:
    // `modes`: those of the system. `scale`, `tolerance`: as Dop853 takes them. `shortest`: s,
    // below which time counts as standing still.
    ModeSteps(System& system, Modes& modes, const std::vector<double>& scale, double tolerance,
              double shortest);

    void restart(double t, const double* y) override;
    void let_through(std::function<void()> ask) override { let_through_ = std::move(ask); }
    StepOutcome step(double t_limit) override;
    double time() const override { return t_; }
    const double* state() const override { return y_.data(); }
    int dense_order() const override { return 7; }
    void dense(double t, double* y) const override;
    double local_error() const override { return smooth_.local_error(); }

  private:
    static constexpr int kLooks = 8;  // at a step, for the end of a mode in it
    static constexpr int kMostAtOnce = 300;
    static constexpr double kNothing = 1e3;  // times shortest: between two ends at once
    bool ends_between(double from, double to);
    double end_of_mode(double from, double to);
    const std::vector<double>& margins(double t);

    Modes& modes_;
    Dop853 smooth_;
    double shortest_, t_ = 0, ended_ = 0;
    int at_once_ = 0;
    bool ends_ = false;  // the mode, at t_
    std::vector<double> y_, look_, before_, after_, margin_;
    std::function<void()> let_through_;
};

}  // namespace serpenoid
