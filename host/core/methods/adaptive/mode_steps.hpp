// Motion in modes (wheels that rest or slide): smooth steps from one mode's end to the next, by
// dop853, or by implicit steps once it is stiff.
//
// A step that went beyond the end of a mode is right up to there: the end is found on its dense
// output, and the next step starts from it in the modes that follow.
#pragma once

#include <optional>
#include <vector>

#include "methods/adaptive/dop853.hpp"
#include "methods/adaptive/radau.hpp"
#include "methods/method.hpp"
#include "scene/system.hpp"

namespace serpenoid {

class ModeSteps final : public Method {
  public:
    // `modes`: those of the system. `scale`, `tolerance`: as Dop853 takes them. `shortest`: s,
    // below which time counts as standing still.
    ModeSteps(System& system, Sticking& modes, const std::vector<double>& scale, double tolerance,
              double shortest);

    void restart(double t, const double* y) override;
    StepOutcome step(double t_limit) override;
    double time() const override { return t_; }
    const double* state() const override { return y_.data(); }
    int dense_order() const override { return 7; }
    void dense(double t, double* y) const override;
    double local_error() const override { return smooth_->local_error(); }

  private:
    static constexpr int kSamples = 8;  // samples of a step, for the end of a mode in it
    static constexpr int kHalvings =
        10;  // halvings between two samples, for a margin's least value
    static constexpr int kMostAtOnce =
        300;                                // ends of modes without progress, before a run gives up
    static constexpr int kStiffSteps = 12;  // stiff steps, more than others, before implicit ones
    static constexpr double kNothing =
        1e3;  // multiple of the shortest time that is no progress yet
    struct Sample {
        double t;
        std::vector<double> margin;
        bool ended(double depth = 0) const;
    };
    void look_for_stiffness();
    bool ends_between(double start, double end);
    bool dips(const Sample& a, const Sample& b, const Sample& c, const Sample& d, int halvings);
    double end_of_mode(Sample start, Sample end);
    Sample sample_at(double t);

    Sticking& modes_;
    Dop853 explicit_;
    Radau stiff_;
    Method* smooth_ = &explicit_;  // the one that steps
    double pays_;                  // decay in an explicit step from which implicit ones pay
    int stiff_steps_ = 0;
    double shortest_, t_ = 0, ended_ = 0;
    int at_once_ = 0;
    bool ends_ = false;           // the mode, at t_
    std::optional<Sample> last_;  // of the step before, in the same mode
    std::vector<double> y_, sampled_state_;
};

}  // namespace serpenoid
