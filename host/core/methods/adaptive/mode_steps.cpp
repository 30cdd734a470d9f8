// The steps of mode_steps.hpp, and the search for the end of a mode.
#include "methods/adaptive/mode_steps.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace serpenoid {

namespace {
// Set on 24 random dry runs, and `progress` on 30 whose servos and torques are strong.
constexpr struct {
    // Samples of a step in the search for the end of a mode, and halvings between two of them in
    // the search for a dip. They find a wheel that slides back for a thousandth of a cycle, in 1.02
    // times the time of a search without dips.
    int samples = 8, halvings = 10;
    // Ends of modes without progress before a run fails: wheels that chatter would go on for ever.
    int max_repeats = 300;
    // Time that counts as progress, over the shortest step: wheels of strong servos turn within it.
    double progress = 1e3;
    // Excess of stiff steps before implicit steps begin: a single fast decay does not pay for them.
    int stiff_steps = 12;
} kSearch;
}  // namespace

ModeSteps::ModeSteps(System& system, Sticking& modes, const std::vector<double>& scale,
                     double tolerance, double min_step)
    : modes_(modes),
      explicit_(system, scale, tolerance),
      stiff_(system, scale, tolerance, {.resolved = 1, .rate = 0.3}),
      stiff_decay_(std::min(6.0, 0.07 * stiff_.unknowns() * stiff_.unknowns())),
      min_step_(min_step),
      y_(system.dim()),
      sampled_state_(system.dim()) {}

void ModeSteps::restart(double t, const double* y) {
    std::copy_n(y, y_.size(), y_.begin());
    modes_.find_modes(t, y_.data());
    smooth_->restart(t, y_.data());
    t_ = t;
    mode_ends_ = false;
    last_sample_.reset();
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

// The first time after the end of a mode: regula falsi for the contact that ends first, with
// bisection at every third sample.
double ModeSteps::end_of_mode(Sample start, Sample end) {
    for (int samples = 0; samples < 100; ++samples) {
        double first = 1, deepest = 0;
        for (std::size_t i = 0; i < end.margin.size(); ++i) {
            if (!(end.margin[i] < 0)) continue;
            deepest = std::min(deepest, end.margin[i]);
            const double above = std::max(start.margin[i], 0.0);
            first = std::min(first, (above + 0.5) / (above - end.margin[i]));
        }
        if (deepest >= -1 || end.t - start.t <= min_step_) break;
        const double part = samples % 3 == 2 ? 0.5 : std::clamp(first, 1e-9, 1 - 1e-9);
        const double t = start.t + part * (end.t - start.t);
        if (!(t > start.t && t < end.t)) break;
        Sample sample = sample_at(t);
        (sample.ended() ? end : start) = std::move(sample);
    }
    return end.t;
}

// Search between samples b and c for a mode that ends and begins again: a margin falls before b and
// rises after c, and the lines through a, b and c, d intersect below 0. If there is one, set t_ to
// its end. A dip to a margin of -1, the error of an end, does not count, because the mode would
// begin again at once.
bool ModeSteps::find_dip(const Sample& a, const Sample& b, const Sample& c, const Sample& d,
                         int halvings) {
    bool may_dip = false;
    for (std::size_t i = 0; i < b.margin.size() && halvings > 0; ++i) {
        const double falls = (b.margin[i] - a.margin[i]) / (b.t - a.t);
        const double rises = (d.margin[i] - c.margin[i]) / (d.t - c.t);
        const double above = b.margin[i] - c.margin[i] + rises * (c.t - b.t);
        may_dip |= falls < 0 && rises > 0 && b.margin[i] * (rises - falls) + falls * above < 0;
    }
    if (!may_dip) return false;
    const Sample middle = sample_at(0.5 * (b.t + c.t));
    if (!middle.ended(1))
        return find_dip(a, b, middle, c, halvings - 1) || find_dip(b, middle, c, d, halvings - 1);
    t_ = end_of_mode(b, middle);
    return true;
}

// Search a step for the first end of a mode; if there is one, set t_ to it.
bool ModeSteps::find_end(double start, double end) {
    std::vector<Sample> samples{last_sample_ ? *std::exchange(last_sample_, {}) : sample_at(start)};
    for (int k = 1; k <= kSearch.samples; ++k) {
        samples.push_back(
            sample_at(k == kSearch.samples ? end : start + (end - start) * k / kSearch.samples));
        if (k > 2 &&
            find_dip(samples[k - 3], samples[k - 2], samples[k - 1], samples[k], kSearch.halvings))
            return true;
        if (samples[k].ended()) {
            t_ = end_of_mode(samples[k - 1], samples[k]);
            return true;
        }
    }
    last_sample_ = std::move(samples.back());
    return false;
}

// Change to implicit steps after some more explicit steps with fast decays than without.
void ModeSteps::check_stiffness() {
    if (smooth_ == &stiff_) return;
    stiff_steps_ = std::max(0, stiff_steps_ + (explicit_.decay() > stiff_decay_ ? 1 : -1));
    if (stiff_steps_ < kSearch.stiff_steps) return;
    stiff_.begin(t_, y_.data(), explicit_.next_step(), 0);
    smooth_ = &stiff_;
}

const char* ModeSteps::step(double t_limit) {
    check_stiffness();
    if (mode_ends_) {
        repeats_ = t_ - last_end_ > kSearch.progress * min_step_ ? 0 : repeats_ + 1;
        if (repeats_ > kSearch.max_repeats)
            return "the wheels stick and slip too often to be followed";
        last_end_ = t_;
        modes_.find_modes(t_, y_.data());
        last_sample_.reset();
        smooth_->restart(t_, y_.data());
    }
    const double start = t_;
    if (const char* failure = smooth_->step(t_limit)) return failure;
    mode_ends_ = find_end(start, smooth_->time());
    if (!mode_ends_) t_ = smooth_->time();
    dense(t_, y_.data());
    if (!mode_ends_) mode_ends_ = modes_.creeps(t_, y_.data());
    return nullptr;
}

void ModeSteps::dense(double t, double* y) const {
    if (t >= smooth_->time())
        std::copy_n(smooth_->state(), y_.size(), y);
    else
        smooth_->dense(t, y);
}

}  // namespace serpenoid
