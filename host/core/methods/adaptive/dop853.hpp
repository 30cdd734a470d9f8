// Dormand and Prince's explicit Runge-Kutta method of order 8 with adaptive steps.
#pragma once

#include <utility>
#include <vector>

#include "methods/adaptive/dop853_table.hpp"
#include "methods/method.hpp"
#include "scene/system.hpp"

namespace serpenoid {

// A step is 12 rates. Its error is estimated from the embedded formulas of order 5 and 3 (Hairer,
// Norsett, Wanner, Solving Ordinary Differential Equations I, II.10) as
//
//     h e5^2 / sqrt(e5^2 + 0.01 e3^2),   e = max_i |difference_i| / scale_i,
//
// and held below the tolerance by a proportional-integral controller. Between the ends of a step
// a polynomial of order 7 holds, which three more rates give when it is first asked for.
//
// An explicit method has to resolve the fastest decay of a system even where nothing moves by it.
// From stages 11 and 12, both at the end of the step, comes h |lambda| of that decay; a
// run ends after some steps in a row at the edge of the stability region, if millions are to come.
class Dop853 final : public Method {
  public:
    // `scale`: what counts as 1 in each entry of the state.
    Dop853(System& system, const std::vector<double>& scale, double tolerance);

    // With a first step as long as the next one would have been.
    void restart(double t, const double* y) override;
    const char* step(double t_limit) override;
    double time() const override { return t_; }
    const double* state() const override { return y_.data(); }
    int dense_order() const override { return 7; }
    void dense(double t, double* y) const override;
    double local_error() const override { return error_ * tolerance_; }
    double next_step() const { return h_next_; }
    double decay() const { return decay_; }  // h |lambda| of the last step

  private:
    template <int... j>
    double sum(const double* row, int i, std::integer_sequence<int, j...>) const;
    template <int stage>
    void combine(double h, double* state) const;
    template <int stage>
    void evaluate(double h) const;
    void stages(double h);
    double error(double h) const;
    bool stiff(double h);
    void finish_dense() const;
    double* k(int stage) const { return k_.data() + stage * dim_; }

    System& system_;
    int dim_;
    double tolerance_;
    std::vector<double> weight_;  // 1 / (scale tolerance)
    double t_ = 0, t_old_ = 0, h_ = 0, h_next_ = 0, error_ = 0, error_old_ = 1, decay_ = 0;
    int stiff_steps_ = 0;
    std::vector<double> y_, y_old_;
    // dense output completes the stages of a step that is otherwise over
    mutable std::vector<double> z_, k_, dense_;
    mutable bool dense_ready_ = false;
};

}  // namespace serpenoid
