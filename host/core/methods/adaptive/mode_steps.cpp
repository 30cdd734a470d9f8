// The steps of mode_steps.hpp, and how the end of a mode is found.
#include "methods/adaptive/mode_steps.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace serpenoid {

ModeSteps::ModeSteps(System& system, Modes& modes, const std::vector<double>& scale,
                     double tolerance, double shortest)
    : modes_(modes),
      explicit_(system, scale, tolerance),
      stiff_(system, scale, tolerance),
      pays_(std::min(6.0, 0.07 * stiff_.unknowns() * stiff_.unknowns())),
      shortest_(shortest),
      y_(system.dim()),
      look_(system.dim()) {}

void ModeSteps::restart(double t, const double* y) {
    std::copy_n(y, y_.size(), y_.begin());
    modes_.find(t, y_.data());
    smooth_->restart(t, y_.data());
    t_ = t, ends_ = margins_known_ = false;
}

const std::vector<double>& ModeSteps::margins(double t) {
    smooth_->dense(t, look_.data());
    modes_.margins(t, look_.data(), margin_);
    return margin_;
}

static bool any_ended(const std::vector<double>& margin) {
    return std::any_of(margin.begin(), margin.end(), [](double m) { return m < 0; });
}

// The first instant after an end: false position for the first part to end, halving in between.
double ModeSteps::end_of_mode(double from, double to) {
    for (int look = 0; look < 100; ++look) {
        double first = 1, deepest = 0;
        for (std::size_t i = 0; i < after_.size(); ++i) {
            if (!(after_[i] < 0)) continue;
            deepest = std::min(deepest, after_[i]);
            const double above = std::max(before_[i], 0.0);
            first = std::min(first, (above + 0.5) / (above - after_[i]));
        }
        if (deepest >= -1 || to - from <= shortest_) break;
        const double part = look % 3 == 2 ? 0.5 : std::clamp(first, 1e-9, 1 - 1e-9);
        const double at = from + part * (to - from);
        if (!(at > from && at < to)) break;
        margins(at);
        if (any_ended(margin_))
            to = at, after_ = margin_;
        else
            from = at, before_ = margin_;
    }
    return to;
}

// Look at a step for the first end of a mode; if there is one, t_ is set to it.
bool ModeSteps::ends_between(double from, double to) {
    if (!margins_known_) before_ = margins(from);
    margins_known_ = true;
    for (int k = 1; k <= kLooks; ++k) {
        const double at = k == kLooks ? to : from + (to - from) * k / kLooks;
        after_ = margins(at);
        if (any_ended(after_)) {
            t_ = end_of_mode(from + (to - from) * (k - 1) / kLooks, at);
            return true;
        }
        before_ = after_;
    }
    return false;
}

// From the start of the next mode, in steps as long as the last ones would have been.
void ModeSteps::go_on() {
    if (smooth_ == &stiff_)
        stiff_.begin(t_, y_.data(), stiff_.next_step());
    else
        explicit_.go_on(t_, y_.data());
}

// After explicit steps that had to follow fast decays more often than not, the run goes on in
// implicit ones.
void ModeSteps::look_for_stiffness() {
    if (smooth_ == &stiff_) return;
    stiff_steps_ = std::max(0, stiff_steps_ + (explicit_.decay() > pays_ ? 1 : -1));
    if (stiff_steps_ < kStiffSteps) return;
    stiff_.begin(t_, y_.data(), explicit_.next_step());
    smooth_ = &stiff_;
}

StepOutcome ModeSteps::step(double t_limit) {
    look_for_stiffness();
    if (ends_) {
        at_once_ = t_ - ended_ > kNothing * shortest_ ? 0 : at_once_ + 1;
        if (at_once_ > kMostAtOnce)
            return {false, "the wheels stick and slip too often to be followed"};
        ended_ = t_;
        modes_.find(t_, y_.data());
        margins_known_ = false;
        go_on();
    }
    const double from = t_;
    const StepOutcome out = smooth_->step(t_limit);
    if (!out.ok) return out;
    ends_ = ends_between(from, smooth_->time());
    if (!ends_) t_ = smooth_->time();
    dense(t_, y_.data());
    if (!ends_) ends_ = modes_.creeps(t_, y_.data());
    return out;
}

void ModeSteps::dense(double t, double* y) const {
    if (t >= smooth_->time())
        std::copy_n(smooth_->state(), y_.size(), y);
    else
        smooth_->dense(t, y);
}

}  // namespace serpenoid
