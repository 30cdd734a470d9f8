// Radau IIA of order 9 for any system whose motion is smooth: for decays that are faster than what
// is to be followed.
#pragma once

#include <array>
#include <vector>

#include "methods/method.hpp"
#include "numerics/dense.hpp"
#include "numerics/radau_collocation.hpp"
#include "scene/system.hpp"

namespace serpenoid {

// The unknowns are the rates v at the stages; the places are q_0 + h A v. Newton's method has the
// derivatives of the accelerations by differences at every stage, because directions of strong
// friction turn within a step. What is integrated beside the motion follows it and chooses nothing.
//
// The error is that of the polynomial through the stages (radau_collocation.hpp), filtered by
// (1 - h J)^-1 as Hairer and Wanner do (IV.8): in a stiff direction it is then the distance from
// the slow motion, and not the fast rate back to it.
class StiffSteps final : public Method {
  public:
    // `scale`: what counts as 1 in each entry of the state.
    StiffSteps(System& system, const std::vector<double>& scale, double tolerance);

    void restart(double t, const double* y) override { begin(t, y, 0); }
    // The same, with the length of the first step.
    void begin(double t, const double* y, double first_step);
    StepOutcome step(double t_limit) override;
    double time() const override { return t_; }
    const double* state() const override { return y_.data(); }
    int dense_order() const override { return kStages; }
    void dense(double t, double* y) const override;
    double local_error() const override { return error_ * tolerance_; }
    double next_step() const { return h_next_; }
    int unknowns() const { return static_cast<int>(entry_.size()); }

  private:
    static constexpr int kStages = 5;
    using Rule = RadauRule<kStages>;
    using Vector = std::vector<double>;
    struct Entry {
        int place, rate;
    };
    struct Slopes {
        Vector by_rate, by_place;  // derivatives of the accelerations, by rows
    };
    double first_step(double t_limit) const;
    void predict(double h);
    void set_places(double h);
    void differentiate(double t, const Vector& y, const Vector& rate, Slopes& to);
    void differentiate_all(double h);
    Vector push(double h);
    double in_fast_decay(double h);
    bool factor(double h);
    bool factor_filter(double h);  // 1 - h slopes_[0].by_rate
    double iterate(double h, bool first, bool anew);
    bool solve(double h);
    double error(double h);
    void accept(double h, double t);

    System& system_;
    double tolerance_, unit_s_;
    std::vector<Entry> entry_;
    std::vector<int> sums_;  // entries that are integrated beside the motion
    Vector weight_;          // 1 / (scale tolerance)
    double t_ = 0, t_old_ = 0, h_ = 0, h_next_ = 0, error_ = 0, before_ = 1;
    Vector y_, y_old_, start_rate_, beside_, moved_;
    std::array<Vector, kStages> stage_, rate_, past_;  // of this step; stages of the last one
    std::array<Slopes, kStages> slopes_;
    Slopes at_start_;
    bool start_known_ = false, end_known_ = false;  // whether slopes are of this very place
    DenseFactors newton_, filter_;
    Vector change_, defect_;
};

}  // namespace serpenoid
