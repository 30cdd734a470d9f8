// Steps of a motion in modes, in which contacts rest or slide: smooth steps by dop853 from the end
// of one mode to the end of the next, or by an implicit method if the motion is stiff.
//
// A step that passes the end of a mode is correct until this end. The end is located on the dense
// output of the step, and the next step starts there in new modes.
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
    // modes: those of the system. scale, tolerance: see Dop853. min_step: resolution of time, s.
    ModeSteps(System& system, Sticking& modes, const std::vector<double>& scale, double tolerance,
              double min_step);

    void restart(double t, const double* y) override;
    const char* step(double t_limit) override;
    double time() const override { return t_; }
    const double* state() const override { return y_.data(); }
    int dense_order() const override { return 7; }
    void dense(double t, double* y) const override;
    double local_error() const override { return smooth_->local_error(); }

  private:
    struct Sample {
        double t;
        std::vector<double> margin;
        bool ended(double depth = 0) const;
    };
    void check_stiffness();
    bool find_end(double start, double end);
    bool find_dip(const Sample& a, const Sample& b, const Sample& c, const Sample& d, int halvings);
    double end_of_mode(Sample start, Sample end);
    Sample sample_at(double t);

    Sticking& modes_;
    Dop853 explicit_;
    Radau stiff_;
    Method* smooth_ = &explicit_;  // the method of the present step
    double stiff_decay_;           // decay in an explicit step above which implicit ones are faster
    int stiff_steps_ = 0;
    double min_step_, t_ = 0, last_end_ = 0;
    int repeats_ = 0;
    bool mode_ends_ = false;             // whether a mode ends at t_
    std::optional<Sample> last_sample_;  // end of the last step, if it is in the same mode
    std::vector<double> y_, sampled_state_;
};

}  // namespace serpenoid
