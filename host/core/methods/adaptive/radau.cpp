// The stages, steps and errors of radau.hpp.
#include "methods/adaptive/radau.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace serpenoid {

namespace {
// Of the inverse of the rule's matrix: eigenvalues, and eigenvectors by columns with their inverse;
// of the complex pair real and imaginary part.
constexpr double kMuReal = 3.637834252744496;
constexpr double kMuRe = 2.6810828736277523, kMuIm = -3.050430199247411;
constexpr double kT[3][3] = {
    {0.09443876248897524, -0.14125529502095421, 0.03002919410514742},
    {0.25021312296533332, 0.20412935229379994, -0.38294211275726192},
    {1, 1, 0},
};
constexpr double kInverse[3][3] = {
    {4.17871859155190428, 0.32768282076106237, 0.52337644549944951},
    {-4.17871859155190428, -0.32768282076106237, 0.47662355450055044},
    {0.50287263494578682, -2.57192694985560522, 0.59603920482822492},
};
// Weights of the stages' changes, over h, in the embedded formula.
constexpr double kRootSix = 2.449489742783178;
constexpr double kError[3] = {(-13 - 7 * kRootSix) / 3, (-13 + 7 * kRootSix) / 3, -1.0 / 3};

constexpr int kMaxIterations = 8;
// Share of the tolerance that the iteration may miss. Such errors lean to one side and add up: with
// .01 torque tables at 1e-9 were off by 1e-8, with .0003 by .6e-9, in the same time.
constexpr double kIterationError = 0.0003;
// Weight of an error in motion that the steps resolve: it adds up over the steps that follow
// ringing. With 1 torque tables were off by four tolerances, with 6 by one; servos take a third
// more time.
constexpr double kResolvedWeight = 6;
constexpr double kRemembered = 0.8;      // power of the remaining share, from step to step
constexpr double kMinRemaining = 1e-6;   // share of a change that later ones add to it at least
constexpr double kRateRounding = 1e-14;  // rounding of a rate: an iteration changes it by no less
constexpr double kKeptGrowth = 1.2;      // growth below which a step stays and keeps its matrices
constexpr double kLongestStep = 1.5;     // motion's units of time: no step may miss a beat
constexpr double kFirstStep = 1e-3;      // share of that unit
constexpr double kDifference = 1e-5;     // share of the scale, for derivatives
constexpr double kMinError = 1e-4;       // share of the tolerance, for the choice of the next step
constexpr int kUniform = 2;              // coordinates of a place: the ground is even
constexpr int kMaxTries = 100;           // tries of a step

// For any system, by differences.
class DenseEquations final : public StepEquations {
  public:
    DenseEquations(System& system, const std::vector<double>& scale)
        : system_(system),
          m_(system.coordinates()),
          scale_(scale),
          rate_(system.dim()),
          moved_(rate_),
          by_place_(m_ * m_),
          by_rate_(m_ * m_) {}

    bool linearise(double t, const double* y, double real_s, Complex complex_s) override {
        system_.rate(t, y, rate_.data());
        std::vector<double> shifted(y, y + system_.dim());
        for (int entry = kUniform; entry < 2 * m_; ++entry) {
            double* slopes = &(entry < m_ ? by_place_ : by_rate_)[entry % m_ * m_];
            const double difference = kDifference * scale_[entry];
            shifted[entry] += difference;
            system_.rate(t, shifted.data(), moved_.data());
            shifted[entry] = y[entry];
            for (int row = 0; row < m_; ++row)
                slopes[row] = (moved_[m_ + row] - rate_[m_ + row]) / difference;
        }
        return fill(real_s, real_) && fill(complex_s, complex_);
    }
    void solve(double* change) override { real_.solve(change); }
    void solve(Complex* change) override { complex_.solve(change); }

  private:
    template <class Scalar>
    bool fill(Scalar s, DenseFactors<Scalar>& factors) {
        std::vector<Scalar>& matrix = factors.begin(m_);
        for (int i = 0; i < m_ * m_; ++i)
            matrix[i] = (i % (m_ + 1) == 0 ? s : Scalar{}) - by_rate_[i] - by_place_[i] / s;
        return factors.factor();
    }
    System& system_;
    int m_;
    std::vector<double> scale_, rate_, moved_;
    std::vector<double> by_place_, by_rate_;  // by columns
    DenseFactors<double> real_;
    DenseFactors<Complex> complex_;
};
}  // namespace

Radau::Radau(System& system, const Vector& scale, double tolerance)
    : system_(system),
      m_(system.coordinates()),
      dim_(system.dim()),
      tolerance_(tolerance),
      unit_s_(scale[0] / scale[m_]),
      equations_(system.step_equations()) {
    for (const double entry_scale : scale) weight_.push_back(1 / (entry_scale * tolerance));
    for (Vector* v : {&y_, &y_old_, &scratch_, &moved_}) v->resize(dim_);
    for (Stages* stages : {&stage_, &stage_rate_, &past_})
        for (Vector& v : *stages) v.resize(dim_);
    for (Vector& v : change_) v.resize(m_);
    for (Vector* v : {&real_change_, &filter_, &place_}) v->resize(m_);
    complex_change_.resize(m_);
    if (!equations_) equations_ = std::make_unique<DenseEquations>(system, scale);
    h_next_ = kFirstStep * unit_s_;
}

void Radau::restart_with_step(double t, const double* y, double first_step) {
    t_ = t;
    h_ = 0;
    h_linearised_ = 0;
    h_next_ = first_step;
    remaining_ = 1;
    std::copy_n(y, dim_, y_.begin());
    fresh_ = false;
}

// Derivatives of the accelerations in the middle of a step of h, as it is predicted.
bool Radau::linearise(double h) {
    fresh_ = true;
    h_linearised_ = h;
    return equations_->linearise(t_ + h * Rule::get().c[1], stage_[1].data(), kMuReal / h,
                                 {kMuRe / h, kMuIm / h});
}

// The stages, as the last step's polynomial continues their rates.
void Radau::predict(double h) {
    for (int i = 0; i < kStages; ++i) {
        change_[i].assign(m_, 0.0);
        if (h_ == 0) continue;
        dense(t_ + h * Rule::get().c[i], scratch_.data());
        for (int j = 0; j < m_; ++j) change_[i][j] = scratch_[m_ + j] - y_[m_ + j];
    }
    set_stages(h);
}

void Radau::set_stages(double h) {
    const auto& a = Rule::get().a;
    for (int i = 0; i < kStages; ++i)
        for (int j = 0; j < m_; ++j) {
            double sum = 0;
            for (int k = 0; k < kStages; ++k)
                sum += a[i * kStages + k] * (y_[m_ + j] + change_[k][j]);
            stage_[i][j] = y_[j] + h * sum;
            stage_[i][m_ + j] = y_[m_ + j] + change_[i][j];
        }
}

// One iteration; how far the rates, or the coordinates by them, moved, over the tolerance.
double Radau::iterate(double h) {
    for (int i = 0; i < kStages; ++i)
        system_.rate(t_ + h * Rule::get().c[i], stage_[i].data(), stage_rate_[i].data());
    const double s = kMuReal / h, re = kMuRe / h, im = kMuIm / h;
    for (int j = 0; j < m_; ++j) {
        double force[3] = {}, change[3] = {};
        for (int k = 0; k < 3; ++k)
            for (int i = 0; i < kStages; ++i) {
                force[k] += kInverse[k][i] * stage_rate_[i][m_ + j];
                change[k] += kInverse[k][i] * change_[i][j];
            }
        real_change_[j] = force[0] - s * change[0];
        complex_change_[j] = {force[1] - (re * change[1] - im * change[2]),
                              force[2] - (re * change[2] + im * change[1])};
    }
    equations_->solve(real_change_.data());
    equations_->solve(complex_change_.data());
    double moved = 0, check = 0;
    for (int j = 0; j < m_; ++j) {
        const double weight = std::max(weight_[m_ + j], weight_[j] / s);
        for (int i = 0; i < kStages; ++i) {
            const double step = kT[i][0] * real_change_[j] + kT[i][1] * complex_change_[j].real() +
                                kT[i][2] * complex_change_[j].imag();
            change_[i][j] += step;
            moved = std::max(moved, std::fabs(step) * weight);
            check += step * 0;
        }
    }
    set_stages(h);
    return moved + check;  // the maximum alone would pass over NaN
}

// Before a second iteration tells the contraction, that of steps before stands for it, a little
// less from step to step.
bool Radau::solve(double h) {
    const double enough = std::max(kIterationError, kRateRounding / tolerance_);
    double last_change = 0;
    contraction_ = 0;
    remaining_ = std::pow(remaining_, kRemembered);
    for (iterations_ = 1; iterations_ <= kMaxIterations; ++iterations_) {
        const double change = iterate(h);
        if (!(change < 1e300)) return false;
        if (iterations_ > 1) {
            contraction_ = std::max(change / last_change, 0.3 * contraction_);
            remaining_ = contraction_ < 1 ? contraction_ / (1 - contraction_) : 1;
            remaining_ = std::max(remaining_, kMinRemaining);
        }
        if (change * remaining_ <= enough) return true;
        // at this pace the iterations that are left do not suffice
        const double last = change * std::pow(contraction_, kMaxIterations - iterations_);
        if (iterations_ > 2 && last > enough) return false;
        last_change = change;
    }
    return false;
}

// The embedded error in places, over the tolerance. The places move first: by the accelerations
// there the filter sees its own derivatives by places.
double Radau::error(double h) {
    const double s = kMuReal / h;
    scratch_ = y_;
    for (int j = 0; j < m_; ++j) {
        place_[j] = y_[m_ + j];
        for (int i = 0; i < kStages; ++i) place_[j] += kError[i] / h * (stage_[i][j] - y_[j]);
        scratch_[j] += place_[j] / s;
    }
    system_.rate(t_, scratch_.data(), moved_.data());
    double raw = 0, filtered = 0, worst = 0, check = 0;
    for (int j = 0; j < m_; ++j) {
        filter_[j] = moved_[m_ + j];
        for (int i = 0; i < kStages; ++i) filter_[j] += kError[i] / h * change_[i][j];
        raw = std::max(raw, std::fabs(filter_[j]) * weight_[j]);
    }
    equations_->solve(filter_.data());
    for (int j = 0; j < m_; ++j) {
        filtered = std::max(filtered, std::fabs(filter_[j]) * s * weight_[j]);
        const double place =
            std::max(std::fabs(filter_[j]) * h, std::fabs(filter_[j] + place_[j]) / s);
        worst = std::max(worst, place * weight_[j]);
        check += filter_[j] * 0;
    }
    // the filter leaves resolved motion as it is, and little of what is far faster than the step
    const double resolved = raw > 0 ? std::min(1.0, filtered / raw) : 1;
    worst *= std::max(1.0, kResolvedWeight * resolved * resolved);
    return std::isfinite(worst + check) ? std::max(worst, kMinError) : HUGE_VAL;
}

// By how much the next step may be longer, in the light of the one before (Gustafsson).
double Radau::growth(double h) const {
    const double safety = 0.9 * (2 * kMaxIterations + 1) / (2 * kMaxIterations + iterations_);
    const double trend = h_ > 0 ? h / h_ * std::pow(error_old_ / error_, 0.25) : 1;
    return safety * std::min(1.0, trend) * std::pow(error_, -0.25);
}

// What is integrated beside the motion, and the start of the next step.
void Radau::accept(double h, double t) {
    const auto& a = Rule::get().a;
    for (int i = 0; i < kStages && dim_ > 2 * m_; ++i)
        system_.rate(t_ + h * Rule::get().c[i], stage_[i].data(), stage_rate_[i].data());
    for (int entry = 2 * m_; entry < dim_; ++entry)
        for (int i = 0; i < kStages; ++i) {
            stage_[i][entry] = y_[entry];
            for (int k = 0; k < kStages; ++k)
                stage_[i][entry] += h * a[i * kStages + k] * stage_rate_[k][entry];
        }
    t_old_ = t_;
    t_ = t;
    h_ = h;
    error_old_ = error_;
    std::swap(y_old_, y_);
    std::swap(past_, stage_);
    y_ = past_.back();
    fresh_ = false;
}

StepOutcome Radau::step(double t_limit) {
    const char* why = "its step does not converge, however short";
    for (int tries = 0; tries < kMaxTries; ++tries) {
        const bool last = t_ + 1.01 * h_next_ >= t_limit;
        const double h = last ? t_limit - t_ : h_next_;
        if (!(t_ + h > t_)) break;
        predict(h);
        if ((h != h_linearised_ && !linearise(h)) || !solve(h)) {
            if (fresh_) h_next_ = 0.5 * h;
            h_linearised_ = 0;
            continue;
        }
        error_ = error(h);
        if (error_ > 1) {
            why = "its error stays above the tolerance, however short the step";
            h_next_ = h * std::clamp(growth(h), 0.1, 0.9);
            continue;
        }
        const double longest = std::max(1.0, kLongestStep * unit_s_ / h);
        double grow = std::clamp(growth(h), 0.2, std::min(8.0, longest));
        const bool slow = iterations_ > 2;
        if (!slow && !last && grow >= 1 && grow < kKeptGrowth) grow = 1;
        h_next_ = last ? std::max(h_next_, h * grow) : h * grow;
        accept(h, last ? t_limit : t_ + h);
        if (slow) h_linearised_ = 0;
        return {};
    }
    return {false, why};
}

void Radau::dense(double t, double* y) const {
    const auto w = Rule::get().dense((t - t_old_) / h_);
    for (int i = 0; i < dim_; ++i) {
        y[i] = y_old_[i];
        for (int k = 0; k < kStages; ++k) y[i] += w[k] * (past_[k][i] - y_old_[i]);
    }
}

}  // namespace serpenoid
