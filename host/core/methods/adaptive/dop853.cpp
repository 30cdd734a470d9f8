// The steps, step control and dense output of dop853.hpp.
#include "methods/adaptive/dop853.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace serpenoid {

using namespace dop853;

namespace {
// Safety, longest step, least error, and the edge of stability with its 15 steps are those of
// Hairer's program DOP853, the powers those of his DOPRI5; the other numbers are ours.
constexpr struct {
    // Powers of this error and of the last one in the next step, and its share of what they allow.
    double last_power = 0.04, power = 1.0 / 8 - 0.2 * last_power, safety = 0.9;
    // Shortest next step after a rejected and after an accepted one, and the longest, over this
    // one.
    double rejected = 0.1, shortest = 0.3, longest = 6;
    // Least error that counts as the last one.
    double min_error = 1e-4;
    // h |lambda| of the edge of the stability region, and steps in a row there of a stiff scene.
    double stability = 6.1;
    int stiff_steps = 15;
    // Steps to come that end the run of a stiff scene: ten seconds of work for six links.
    double max_steps = 2e6;
    // First step, as a share of the motion's unit of time.
    double first_step = 0.01;
} kStepControl;
}  // namespace

Dop853::Dop853(System& system, const std::vector<double>& scale, double tolerance)
    : system_(system),
      dim_(system.dim()),
      tolerance_(tolerance),
      weight_(dim_),
      y_(dim_),
      y_old_(dim_),
      z_(dim_),
      k_(kAll * dim_),
      dense_(7 * dim_) {
    h_next_ = kStepControl.first_step * scale[0] / scale[system.coordinates()];
    for (int i = 0; i < dim_; ++i) weight_[i] = 1 / (scale[i] * tolerance);
}

void Dop853::restart(double t, const double* y) {
    t_ = t;
    t_old_ = t;
    h_ = 0;
    error_ = 0;
    error_old_ = kStepControl.min_error;
    stiff_steps_ = 0;
    std::copy_n(y, dim_, y_.begin());
    system_.rate(t, y, k(kStages));
}

// The i-th entry of a row's sum of rates; zeros of the table are gone at compile time.
template <int... j>
[[gnu::always_inline]] inline double Dop853::sum(const double* row, int i,
                                                 std::integer_sequence<int, j...>) const {
    return ((row[j] == 0 ? 0.0 : row[j] * k_[j * dim_ + i]) + ...);
}

template <int stage>
void Dop853::combine(double h, double* state) const {
    for (int i = 0; i < dim_; ++i)
        state[i] = y_old_[i] + h * sum(kA[stage], i, std::make_integer_sequence<int, stage>{});
}

template <int stage>
void Dop853::evaluate(double h) const {
    combine<stage>(h, z_.data());
    system_.rate(t_old_ + kNode[stage] * h, z_.data(), k(stage));
}

void Dop853::stages(double h) {
    [&]<int... stage>(std::integer_sequence<int, stage...>) {
        (evaluate<stage + 1>(h), ...);
    }(std::make_integer_sequence<int, kStages - 1>{});
    combine<kStages>(h, y_.data());
}

// Over the tolerance: 1 is just acceptable.
double Dop853::error(double h) const {
    double e3 = 0, e5 = 0, check = 0;
    for (int i = 0; i < dim_; ++i) {
        const std::make_integer_sequence<int, kStages> stages;
        const double d3 = sum(kE3, i, stages), d5 = sum(kE5, i, stages);
        e3 = std::max(e3, std::fabs(d3) * weight_[i]);
        e5 = std::max(e5, std::fabs(d5) * weight_[i]);
        check += d5 * 0;
    }
    // stages that run away overflow: the squares of such errors would make a quotient of 0
    if (check != 0 || !std::isfinite(e3 + e5)) return std::numeric_limits<double>::infinity();
    return e5 > 0 ? h * e5 * (e5 / std::hypot(e5, 0.1 * e3)) : 0;
}

// Whether stability, not accuracy, bounds the step. k(12) is at the end, k(11) at stage 11's guess
// of it.
bool Dop853::stiff(double h) {
    double rates = 0, states = 0;
    for (int i = 0; i < dim_; ++i) {
        const double dk = k(kStages)[i] - k(kStages - 1)[i], dy = y_[i] - z_[i];
        rates += dk * dk * weight_[i] * weight_[i];
        states += dy * dy * weight_[i] * weight_[i];
    }
    decay_ = states > 0 ? h * std::sqrt(rates / states) : 0;
    stiff_steps_ = decay_ > kStepControl.stability ? stiff_steps_ + 1 : 0;
    return stiff_steps_ >= kStepControl.stiff_steps;
}

const char* Dop853::step(double t_limit) {
    std::copy_n(k(kStages), dim_, k(0));
    std::swap(y_old_, y_);
    t_old_ = t_;
    dense_ready_ = false;
    for (double h = h_next_;;) {
        const bool last = t_old_ + 1.01 * h >= t_limit;
        if (last) h = t_limit - t_old_;
        if (!(h > 4e-16 * std::fabs(t_old_))) {
            y_ = y_old_;
            return "its step fell below the resolution of time";
        }
        stages(h);
        error_ = error(h);
        const double grow = std::pow(std::max(error_, 1e-14), -kStepControl.power);
        if (!(error_ <= 1)) {
            h *= std::max(kStepControl.rejected, kStepControl.safety * grow);
            h_next_ = h;
            continue;
        }
        t_ = last ? t_limit : t_old_ + h;
        h_ = h;
        system_.rate(t_, y_.data(), k(kStages));
        const double factor =
            kStepControl.safety * grow * std::pow(error_old_, kStepControl.last_power);
        h_next_ = std::max(h * std::clamp(factor, kStepControl.shortest, kStepControl.longest),
                           last ? h_next_ : 0);
        error_old_ = std::max(error_, kStepControl.min_error);
        if (stiff(h) && t_limit - t_ > kStepControl.max_steps * h)
            return "the scene is stiff: an explicit method would take millions of steps";
        return nullptr;
    }
}

// Hermite's cubic from both ends, and four more coefficients from all stages.
void Dop853::finish_dense() const {
    evaluate<13>(h_);
    evaluate<14>(h_);
    evaluate<15>(h_);
    for (int i = 0; i < dim_; ++i) {
        const double rise = y_[i] - y_old_[i], start = h_ * k(0)[i], end = h_ * k(kStages)[i];
        dense_[i] = rise;
        dense_[dim_ + i] = start - rise;
        dense_[2 * dim_ + i] = 2 * rise - start - end;
        for (int c = 0; c < 4; ++c) {
            double sum = 0;
            for (int j = 0; j < kAll; ++j) sum += kD[c][j] * k_[j * dim_ + i];
            dense_[(3 + c) * dim_ + i] = h_ * sum;
        }
    }
    dense_ready_ = true;
}

void Dop853::dense(double t, double* y) const {
    if (h_ == 0 || t >= t_) return void(std::copy_n(y_.begin(), dim_, y));
    if (!dense_ready_) finish_dense();
    const double x = (t - t_old_) / h_;
    for (int i = 0; i < dim_; ++i) {
        double p = 0;
        for (int c = 6; c >= 0; --c) p = (p + dense_[c * dim_ + i]) * (c % 2 ? 1 - x : x);
        y[i] = y_old_[i] + p;
    }
}

}  // namespace serpenoid
