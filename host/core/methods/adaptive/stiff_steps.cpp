// The stages, steps and error of stiff_steps.hpp.
#include "methods/adaptive/stiff_steps.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace serpenoid {

namespace {
constexpr int kUniform = 2;      // places of the tail: the ground is the same everywhere
constexpr double kClose = 0.01;  // of the tolerance: what Newton's method may miss
constexpr double kSlow = 0.1;    // contraction at which derivatives are taken anew
constexpr double kTurn = 0.02;   // of the motion's unit of time: a step in which directions turn
constexpr int kMostIterations = 8, kMostSlopes = 3;
}  // namespace

StiffSteps::StiffSteps(System& system, const Vector& scale, double tolerance)
    : system_(system), tolerance_(tolerance) {
    const std::vector<int> rate_of = system.rate_of();
    std::vector<char> paired(scale.size());
    for (std::size_t i = 0; i < scale.size(); ++i) {
        weight_.push_back(1 / (scale[i] * tolerance));
        if (rate_of[i] < 0) continue;
        entry_.push_back({static_cast<int>(i), rate_of[i]});
        paired[i] = paired[rate_of[i]] = true;
    }
    for (std::size_t i = 0; i < scale.size(); ++i)
        if (!paired[i]) sums_.push_back(static_cast<int>(i));
    for (Vector* v : {&y_, &y_old_, &start_rate_, &beside_, &moved_}) v->resize(scale.size());
    for (auto* stages : {&stage_, &rate_, &past_})
        for (Vector& v : *stages) v.resize(scale.size());
    const std::size_t m = entry_.size();
    at_start_.by_rate.resize(m * m), at_start_.by_place.resize(m * m);
    unit_s_ = scale[entry_[0].place] / scale[entry_[0].rate];
    change_.resize(kStages * m);
}

void StiffSteps::begin(double t, const double* y, double first_step) {
    t_ = t, h_ = 0, error_ = 0;
    std::copy_n(y, y_.size(), y_.begin());
    system_.rate(t, y_.data(), start_rate_.data());
    differentiate(t, y_, start_rate_, at_start_);
    start_known_ = true;
    slopes_.fill(at_start_);
    h_next_ = first_step > 0 ? in_fast_decay(first_step) : 0;
}

// Move of the rates over h seconds by one implicit Euler step.
StiffSteps::Vector StiffSteps::push(double h) {
    Vector move;
    for (const Entry& e : entry_) move.push_back(h * start_rate_[e.rate]);
    if (factor_filter(h)) filter_.solve(move);
    return move;
}

bool StiffSteps::factor_filter(double h) {
    const int m = unknowns();
    Vector& A = filter_.begin(m);
    for (int r = 0; r < m; ++r)
        for (int c = 0; c < m; ++c) A[r * m + c] = (r == c) - h * slopes_[0].by_rate[r * m + c];
    return filter_.factor();
}

// A mode may begin with a fast decay, which steps must follow while it is larger than the
// tolerance. Slow motion goes with h, and what has decayed by then does not.
double StiffSteps::in_fast_decay(double h) {
    const auto fast = [&](double from) {
        const Vector whole = push(from), part = push(from / 4);
        double most = 0;
        for (std::size_t r = 0; r < part.size(); ++r)
            most = std::max(most, std::fabs(part[r] - whole[r] / 4) * weight_[entry_[r].rate]);
        return most;
    };
    double to = h, size = fast(h);
    for (double at = h / 4; size > 1; at /= 4) {
        const double next = fast(at);
        if (next > 0.7 * size) to = at;
        size = next;
    }
    return to;
}

// A hundredth of the time in which something moves by its scale.
double StiffSteps::first_step(double t_limit) const {
    double most = 1e-6;
    for (const Entry& e : entry_)
        for (const int i : {e.place, e.rate})
            most = std::max(most, std::fabs(start_rate_[i]) * weight_[i] * tolerance_);
    return std::min(0.01 / most, t_limit - t_);
}

// The stages' rates: on the last step's polynomial where there is one.
void StiffSteps::predict(double h) {
    for (int j = 0; j < kStages; ++j) {
        stage_[j] = y_;
        if (h_ > 0 && h < 3 * h_) dense(t_ + h * Rule::get().c[j], stage_[j].data());
    }
}

void StiffSteps::set_places(double h) {
    for (int j = 0; j < kStages; ++j)
        for (const Entry& e : entry_) {
            double sum = 0;
            for (int k = 0; k < kStages; ++k)
                sum += Rule::get().a[j * kStages + k] * stage_[k][e.rate];
            stage_[j][e.place] = y_[e.place] + h * sum;
        }
}

// Derivatives of the accelerations at a state. They are almost linear in the rates.
void StiffSteps::differentiate(double t, const Vector& y, const Vector& rate, Slopes& to) {
    constexpr double kAside = 1e-5;  // of the scale
    const int m = unknowns();
    beside_ = y;
    for (int c = 0; c < m; ++c)
        for (const bool by_rate : {true, false}) {
            Vector& slopes = by_rate ? to.by_rate : to.by_place;
            if (!by_rate && c < kUniform) continue;
            const int at = by_rate ? entry_[c].rate : entry_[c].place;
            const double aside = kAside / (weight_[at] * tolerance_);
            beside_[at] += aside;
            system_.rate(t, beside_.data(), moved_.data());
            beside_[at] = y[at];
            for (int r = 0; r < m; ++r)
                slopes[r * m + c] = (moved_[entry_[r].rate] - rate[entry_[r].rate]) / aside;
        }
}

// At the start, a stage in the middle and the end, and by parabolas at the stages between.
void StiffSteps::differentiate_all(double h) {
    constexpr int kMiddle = kStages / 2, kEnd = kStages - 1;
    const Rule& rule = Rule::get();
    if (!start_known_) differentiate(t_, y_, start_rate_, at_start_);
    start_known_ = true;
    for (const int j : {kMiddle, kEnd})
        differentiate(t_ + h * rule.c[j], stage_[j], rate_[j], slopes_[j]);
    const double c = rule.c[kMiddle];
    for (int j = 0; j < kEnd; ++j) {
        if (j == kMiddle) continue;
        const double x = rule.c[j], start = (1 - x) * (c - x) / c, end = x * (x - c) / (1 - c);
        const auto mix = [&](const Vector& a, const Vector& b, const Vector& e, Vector& to) {
            for (std::size_t i = 0; i < to.size(); ++i)
                to[i] = start * a[i] + (1 - start - end) * b[i] + end * e[i];
        };
        for (const auto part : {&Slopes::by_rate, &Slopes::by_place})
            mix(at_start_.*part, slopes_[kMiddle].*part, slopes_[kEnd].*part, slopes_[j].*part);
    }
    end_known_ = true;
}

bool StiffSteps::factor(double h) {
    const Rule& rule = Rule::get();
    const int m = unknowns(), size = kStages * m;
    Vector& A = newton_.begin(size);
    for (int j = 0; j < kStages; ++j) {
        for (int k = 0; k < kStages; ++k)
            for (int r = 0; r < m; ++r)
                for (int c = 0; c < m; ++c)
                    A[(j * m + r) * size + k * m + c] =
                        (r == c ? rule.rate[j * kStages + k] : 0) -
                        (j == k ? h * slopes_[j].by_rate[r * m + c] : 0) -
                        h * h * rule.a[j * kStages + k] * slopes_[j].by_place[r * m + c];
    }
    return newton_.factor();
}

// One iteration; how far the rates moved, over the tolerance.
double StiffSteps::iterate(double h, bool first, bool anew) {
    const Rule& rule = Rule::get();
    const int m = unknowns();
    set_places(h);
    for (int j = 0; j < kStages; ++j)
        system_.rate(t_ + h * rule.c[j], stage_[j].data(), rate_[j].data());
    if (anew) differentiate_all(h);
    if ((anew || first) && !factor(h)) return HUGE_VAL;
    for (int j = 0; j < kStages; ++j)
        for (int r = 0; r < m; ++r) {
            const int i = entry_[r].rate;
            double left = h * rate_[j][i];
            for (int k = 0; k < kStages; ++k)
                left -= rule.rate[j * kStages + k] * (stage_[k][i] - y_[i]);
            change_[j * m + r] = left;
        }
    newton_.solve(change_);
    double most = 0, check = 0;
    for (int j = 0; j < kStages; ++j)
        for (int r = 0; r < m; ++r) {
            const int i = entry_[r].rate;
            stage_[j][i] += change_[j * m + r];
            most = std::max(most, std::fabs(change_[j * m + r]) * weight_[i]);
            check += change_[j * m + r] * 0;
        }
    return most + check;
}

bool StiffSteps::solve(double h) {
    const double close = std::max(kClose, 1e-14 / tolerance_);
    predict(h);
    end_known_ = false;
    double before = 0, contraction = h > kTurn * unit_s_ ? 1 : 0;
    for (int i = 0, taken = 0; i < kMostIterations; ++i) {
        const bool anew = contraction > kSlow && taken < kMostSlopes;
        taken += anew;
        const double now = iterate(h, i == 0, anew);
        if (!(now < 1e300)) return false;
        contraction = i > 0 ? now / before : 0;
        if (contraction > 1 && taken == kMostSlopes) return false;
        const double next = contraction < 1 ? now * contraction / (1 - contraction) : now;
        if (now <= close || (i > 0 && next <= close)) return set_places(h), true;
        before = now;
    }
    return false;
}

// Of the polynomial's largest deviation; the place's part is no stiff one.
double StiffSteps::error(double h) {
    const Rule& rule = Rule::get();
    const int m = unknowns();
    const double b = h * rule.bump_height;
    defect_.resize(m);
    double most = 0;
    for (int r = 0; r < m; ++r) {
        const Entry e = entry_[r];
        double slope = 0, rate = 0;
        for (int k = 0; k < kStages; ++k) {
            slope += rule.slope0[k] / h * (stage_[k][e.rate] - y_[e.rate]);
            rate += rule.at0[k] * stage_[k][e.rate];
        }
        most = std::max(most, b * std::fabs(rate - y_[e.rate]) * weight_[e.place]);
        defect_[r] = b * (slope - start_rate_[e.rate]);
    }
    if (!factor_filter(b)) return HUGE_VAL;
    filter_.solve(defect_);
    for (int r = 0; r < m; ++r)
        most = std::max(most, std::fabs(defect_[r]) * weight_[entry_[r].rate]);
    return most;
}

// What is integrated beside the motion, and the start of the next step.
void StiffSteps::accept(double h, double t) {
    const Rule& rule = Rule::get();
    for (int j = 0; j < kStages && !sums_.empty(); ++j)
        system_.rate(t_ + h * rule.c[j], stage_[j].data(), rate_[j].data());
    for (const int i : sums_)
        for (int j = 0; j < kStages; ++j) {
            stage_[j][i] = y_[i];
            for (int k = 0; k < kStages; ++k)
                stage_[j][i] += h * rule.a[j * kStages + k] * rate_[k][i];
        }
    t_old_ = t_, t_ = t, h_ = h;
    std::swap(y_old_, y_);
    std::swap(past_, stage_);
    y_ = past_.back();
    start_known_ = end_known_;
    if (end_known_) at_start_ = slopes_.back();
    system_.rate(t_, y_.data(), start_rate_.data());
}

StepOutcome StiffSteps::step(double t_limit) {
    if (h_next_ == 0) h_next_ = first_step(t_limit);
    constexpr double kOrder = kStages + 1, kLeast = 1e-14;
    double tried = HUGE_VAL;
    for (double h = h_next_;;) {
        const bool last = t_ + 1.01 * h >= t_limit;
        if (last) h = t_limit - t_;
        if (!(h > 4e-16 * std::fabs(t_)))
            return {false, "its step fell below the resolution of time"};
        error_ = solve(h) ? std::max(error(h), kLeast) : HUGE_VAL;
        double grow = 0.9 * std::pow(error_, -1 / kOrder);
        if (error_ <= 1) {
            // in a decay the next error falls as this one did
            if (h_ > 0)
                grow *= std::clamp(std::pow(before_ / error_, 1 / kOrder) * h / h_, 1.0, 2.0);
            before_ = error_;
            h_next_ = std::max(h * std::clamp(grow, 0.3, 20.0), last ? h_next_ : 0);
            accept(h, last ? t_limit : t_ + h);
            return {};
        }
        // an error that does not fall with the step is that of a decay far shorter
        const bool flat = error_ < HUGE_VAL && error_ > 0.3 * tried;
        tried = error_;
        h *= flat ? 0.1 : std::clamp(grow, 0.25, 0.8);
    }
}

void StiffSteps::dense(double t, double* y) const {
    const auto w = Rule::get().dense((t - t_old_) / h_);
    for (std::size_t i = 0; i < y_.size(); ++i) {
        y[i] = y_old_[i];
        for (int k = 0; k < kStages; ++k) y[i] += w[k] * (past_[k][i] - y_old_[i]);
    }
}

}  // namespace serpenoid
