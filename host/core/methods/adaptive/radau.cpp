// The stages, steps and errors of radau.hpp.
#include "methods/adaptive/radau.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace serpenoid {

namespace {
// The inverse of the rule's matrix: one real eigenvalue and a complex pair, eigenvectors by columns
// (of the pair real and imaginary part), and the inverse of their matrix.
constexpr struct {
    double real, re, im;
    double vectors[3][3], inverse[3][3];
} kEigen{3.637834252744496,
         2.6810828736277523,
         -3.050430199247411,
         {{0.09443876248897524, -0.14125529502095421, 0.03002919410514742},
          {0.25021312296533332, 0.20412935229379994, -0.38294211275726192},
          {1, 1, 0}},
         {{4.17871859155190428, 0.32768282076106237, 0.52337644549944951},
          {-4.17871859155190428, -0.32768282076106237, 0.47662355450055044},
          {0.50287263494578682, -2.57192694985560522, 0.59603920482822492}}};
// Weights of the stages' changes, over h, in the embedded formula: (-13 -+ 7 sqrt 6) / 3, -1/3.
constexpr double kError[3] = {-10.048809399827416, 1.3821427331607488, -1.0 / 3};

// Set like SwitchedSteps::kSwitching, on springs with 6, 24 and 50 links.
constexpr struct {
    // Share of the tolerance that the iteration may miss. Such errors lean to one side and add up:
    // with .01 torque tables at 1e-9 were off by 1e-8, with .0003 by .6e-9, in the same time.
    double iteration_error = 0.0003;
    // Rounding of a rate: an iteration changes it by no less.
    double rate_rounding = 1e-14;
    // Iterations of a step at most; further ones converge too slowly to pay.
    int iterations = 8;
    // Longest and first step, in the motion's unit of time: no step may miss a beat.
    double longest_step = 1.5, first_step = 1e-3;
    // Share of the scale, for derivatives by differences: above the root of rounding, as forces
    // have kinks.
    double difference = 1e-5;
} kRadauTuning;

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
        // from the first angle: the ground is even, no force depends on x and y
        for (int entry = 2; entry < 2 * m_; ++entry) {
            double* slopes = &(entry < m_ ? by_place_ : by_rate_)[entry % m_ * m_];
            const double difference = kRadauTuning.difference * scale_[entry];
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

Radau::Radau(System& system, const Vector& scale, double tolerance, const Weights& weights)
    : system_(system),
      m_(system.coordinates()),
      dim_(system.dim()),
      tolerance_(tolerance),
      unit_s_(scale[0] / scale[m_]),
      weights_(weights),
      equations_(system.step_equations()) {
    for (const double entry_scale : scale) weight_.push_back(1 / (entry_scale * tolerance));
    for (Vector* v : {&y_, &y_old_, &scratch_, &moved_}) v->resize(dim_);
    for (Stages* stages : {&stage_, &stage_rate_, &past_})
        for (Vector& v : *stages) v.resize(dim_);
    for (Vector& v : change_) v.resize(m_);
    for (Vector* v : {&real_change_, &filter_, &place_}) v->resize(m_);
    complex_change_.resize(m_);
    if (!equations_) equations_ = std::make_unique<DenseEquations>(system, scale);
    h_next_ = kRadauTuning.first_step * unit_s_;
}

void Radau::begin(double t, const double* y, double first, double shortest) {
    t_ = t;
    h_ = 0;
    h_next_ = first;
    shortest_ = shortest;
    std::copy_n(y, dim_, y_.begin());
}

// Derivatives of the accelerations in the middle of a step of h, as it is predicted.
bool Radau::linearise(double h) {
    return equations_->linearise(t_ + h * Rule::get().c[1], stage_[1].data(), kEigen.real / h,
                                 {kEigen.re / h, kEigen.im / h});
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
    const double s = kEigen.real / h, re = kEigen.re / h, im = kEigen.im / h;
    for (int j = 0; j < m_; ++j) {
        double force[3] = {}, change[3] = {};
        for (int k = 0; k < 3; ++k)
            for (int i = 0; i < kStages; ++i) {
                force[k] += kEigen.inverse[k][i] * stage_rate_[i][m_ + j];
                change[k] += kEigen.inverse[k][i] * change_[i][j];
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
            const double step = kEigen.vectors[i][0] * real_change_[j] +
                                kEigen.vectors[i][1] * complex_change_[j].real() +
                                kEigen.vectors[i][2] * complex_change_[j].imag();
            change_[i][j] += step;
            moved = std::max(moved, std::fabs(step) * weight);
            check += step * 0;
        }
    }
    set_stages(h);
    return moved + check;  // the maximum alone would pass over NaN
}

bool Radau::solve(double h) {
    const double enough =
        std::max(kRadauTuning.iteration_error, kRadauTuning.rate_rounding / tolerance_);
    double last_change = 0, contraction = 0;
    for (iterations_ = 1; iterations_ <= kRadauTuning.iterations; ++iterations_) {
        const double change = iterate(h);
        if (!(change < 1e300)) return false;
        double remaining = change;  // what later iterations would add
        if (iterations_ > 1) {
            contraction = std::max(change / last_change, 0.3 * contraction);
            if (contraction < 1) remaining *= contraction / (1 - contraction);
        }
        if (remaining <= enough) return true;
        // at this pace the iterations that are left do not suffice
        const double last = change * std::pow(contraction, kRadauTuning.iterations - iterations_);
        if (iterations_ > 2 && last > enough) return false;
        last_change = change;
    }
    return false;
}

// The embedded error in places, over the tolerance. The places move first: by the accelerations
// there the filter sees its own derivatives by places.
double Radau::error(double h) {
    const double s = kEigen.real / h;
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
        const double rate = weights_.rate * std::fabs(filter_[j]);
        worst = std::max({worst, place * weight_[j], rate * weight_[m_ + j]});
        check += filter_[j] * 0;
    }
    // the filter leaves resolved motion as it is, and little of what is far faster than the step
    const double resolved = raw > 0 ? std::min(1.0, filtered / raw) : 1;
    worst *= std::max(1.0, weights_.resolved * resolved * resolved);
    return std::isfinite(worst + check) ? worst : HUGE_VAL;
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
    std::swap(y_old_, y_);
    std::swap(past_, stage_);
    y_ = past_.back();
}

const char* Radau::step(double t_limit) {
    for (const char* why = "its step does not converge, however short";;) {
        const bool last = t_ + 1.01 * h_next_ >= t_limit;
        const double h = last ? t_limit - t_ : h_next_;
        if (!(t_ + h > t_) || h_next_ < shortest_) return why;
        predict(h);
        if (!linearise(h) || !solve(h)) {
            h_next_ = 0.5 * h;
            continue;
        }
        error_ = error(h);
        const double next = h * std::clamp(0.8 * std::pow(error_, -0.25), 0.1, 8.0);
        if (error_ > 1) {
            why = "its error stays above the tolerance, however short the step";
            h_next_ = std::min(next, 0.9 * h);
            continue;
        }
        h_next_ =
            std::min(last ? std::max(h_next_, next) : next, kRadauTuning.longest_step * unit_s_);
        accept(h, last ? t_limit : t_ + h);
        return nullptr;
    }
}

void Radau::dense(double t, double* y) const {
    const auto w = Rule::get().dense((t - t_old_) / h_);
    for (int i = 0; i < dim_; ++i) {
        y[i] = y_old_[i];
        for (int k = 0; k < kStages; ++k) y[i] += w[k] * (past_[k][i] - y_old_[i]);
    }
}

}  // namespace serpenoid
