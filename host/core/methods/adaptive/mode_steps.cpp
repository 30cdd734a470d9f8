// The steps of mode_steps.hpp, and how the end of a mode is found.
#include "methods/adaptive/mode_steps.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace serpenoid {

ModeSteps::ModeSteps(System& system, Sticking& modes, const std::vector<double>& scale,
                     double tolerance, double shortest)
    : modes_(modes),
      explicit_(system, scale, tolerance),
      stiff_(system, scale, tolerance),
      pays_(std::min(6.0, 0.07 * stiff_.unknowns() * stiff_.unknowns())),
      shortest_(shortest),
      y_(system.dim()),
      sampled_state_(system.dim()) {}

void ModeSteps::restart(double t, const double* y) {
    std::copy_n(y, y_.size(), y_.begin());
    modes_.find(t, y_.data());
    smooth_->restart(t, y_.data());
    t_ = t;
    ends_ = false;
    last_.reset();
}

ModeSteps::Sample ModeSteps::sample_at(double t) {
    Sample sample{t, {}};
    smooth_->dense(t, sampled_state_.data());
    modes_.margins(t, sampled_state_.data(), sample.margin);
    return sample;
}

bool ModeSteps::Sample::ended(double depth) const {
    return std::any_of(margin.begin(), margin.end(), [=](double m) { return m < -depth; });
}

// The first instant after an end: false position for the first part to end, halving in between.
double ModeSteps::end_of_mode(Sample start, Sample end) {
    for (int samples = 0; samples < 100; ++samples) {
        double first = 1, deepest = 0;
        for (std::size_t i = 0; i < end.margin.size(); ++i) {
            if (!(end.margin[i] < 0)) continue;
            deepest = std::min(deepest, end.margin[i]);
            const double above = std::max(start.margin[i], 0.0);
            first = std::min(first, (above + 0.5) / (above - end.margin[i]));
        }
        if (deepest >= -1 || end.t - start.t <= shortest_) break;
        const double part = samples % 3 == 2 ? 0.5 : std::clamp(first, 1e-9, 1 - 1e-9);
        const double t = start.t + part * (end.t - start.t);
        if (!(t > start.t && t < end.t)) break;
        Sample sample = sample_at(t);
        (sample.ended() ? end : start) = std::move(sample);
    }
    return end.t;
}

// Look between b and c for a mode that ends and begins again: a margin falls before them and rises
// after them, and the lines through a, b and c, d meet below 0. If there is one, t_ is set to its
// end. What dips no deeper than the ends of modes are known, 1, is none: it would begin again at
// once.
bool ModeSteps::dips(const Sample& a, const Sample& b, const Sample& c, const Sample& d,
                     int halvings) {
    bool low = false;
    for (std::size_t i = 0; i < b.margin.size() && halvings > 0; ++i) {
        const double falls = (b.margin[i] - a.margin[i]) / (b.t - a.t);
        const double rises = (d.margin[i] - c.margin[i]) / (d.t - c.t);
        const double above = b.margin[i] - c.margin[i] + rises * (c.t - b.t);
        low |= falls < 0 && rises > 0 && b.margin[i] * (rises - falls) + falls * above < 0;
    }
    if (!low) return false;
    const Sample middle = sample_at(0.5 * (b.t + c.t));
    if (!middle.ended(1))
        return dips(a, b, middle, c, halvings - 1) || dips(b, middle, c, d, halvings - 1);
    t_ = end_of_mode(b, middle);
    return true;
}

// Look at a step for the first end of a mode; if there is one, t_ is set to it.
bool ModeSteps::ends_between(double start, double end) {
    std::vector<Sample> samples{last_ ? *std::exchange(last_, {}) : sample_at(start)};
    for (int k = 1; k <= kSamples; ++k) {
        samples.push_back(sample_at(k == kSamples ? end : start + (end - start) * k / kSamples));
        if (k > 2 && dips(samples[k - 3], samples[k - 2], samples[k - 1], samples[k], kHalvings))
            return true;
        if (samples[k].ended()) {
            t_ = end_of_mode(samples[k - 1], samples[k]);
            return true;
        }
    }
    last_ = std::move(samples.back());
    return false;
}

// After explicit steps that had to follow fast decays more often than not, the run goes on in
// implicit ones.
void ModeSteps::look_for_stiffness() {
    if (smooth_ == &stiff_) return;
    stiff_steps_ = std::max(0, stiff_steps_ + (explicit_.decay() > pays_ ? 1 : -1));
    if (stiff_steps_ < kStiffSteps) return;
    stiff_.restart_with_step(t_, y_.data(), explicit_.next_step());
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
        last_.reset();
        smooth_->restart(t_, y_.data());
    }
    const double start = t_;
    const StepOutcome outcome = smooth_->step(t_limit);
    if (!outcome.ok) return outcome;
    ends_ = ends_between(start, smooth_->time());
    if (!ends_) t_ = smooth_->time();
    dense(t_, y_.data());
    if (!ends_) ends_ = modes_.creeps(t_, y_.data());
    return outcome;
}

void ModeSteps::dense(double t, double* y) const {
    if (t >= smooth_->time())
        std::copy_n(smooth_->state(), y_.size(), y);
    else
        smooth_->dense(t, y);
}

}  // namespace serpenoid
