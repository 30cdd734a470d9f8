// Radau IIA with three stages (order 5, L-stable) for  M q'' = force(t, q, q').
//
// The unknowns are the increments Z_i of the places q at the three stages. Their rates V = A^-1 Z/h
// and accelerations A^-1 (V - v_0)/h follow, and what is left to solve is
//     R_i = M acceleration_i - force(t_i, q_0 + Z_i, V_i) = 0.
// Along the eigenvectors of A^-1 (radau_tableau.hpp) the Newton step of an eigenvalue lambda is one
// system  (M s^2 - s dforce/dq' - dforce/dq) dz = -R,  s = lambda/h,  of half the size that y' = f
// has, and block-tridiagonal (stiff_link.hpp): once real, once complex. Its matrices are cheap
// beside the iterations that old ones would cost, so every step has its own.
//
// The error estimate is that of Hairer and Wanner (IV.8): the difference to an embedded formula of
// order 3, filtered by (s - J)^-1. The filter hides stiff ringing that a long step swallows; see
// ringing().
#include "methods/stiff/radau.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "methods/stiff/radau_tableau.hpp"
#include "methods/stiff/stiff_angles.hpp"
#include "methods/stiff/stiff_torques.hpp"

namespace serpenoid {

namespace {

const RadauTableau kRadau;
constexpr int kMostIterations = 10, kMostTries = 100;
constexpr const char* kNoConvergence = "its step does not converge, however short";
constexpr const char* kNoAccuracy = "its error stays above the tolerance, however short the step";

using Vector = std::vector<double>;
using Moments = std::array<Vector, kMoments>;
using Weights = std::array<double, kMoments>;  // of the moments

template <class Model>
class Radau final : public Method {
  public:
    Radau(const RunRequest& q, System& system)
        : model_(q),
          system_(system),
          dim_(model_.dim()),
          sums_(system.dim() - 2 * dim_),
          tolerance_(q.tolerance),
          unit_rate_(std::max(1.0, q.gait.omega)),
          h_(q.tolerance > 0 ? 1e-3 / unit_rate_ : q.dt),
          real_(q.robot.n),
          pair_(q.robot.n),
          pair_z_(dim_),
          pair_dz_(dim_),
          sum_(sums_) {
        for (Vector* v :
             {&q_, &v_, &z_, &dz_, &f_, &eq_, &ev_, &mass_, &unit_, &dense_q_, &dense_v_})
            v->resize(dim_);
        for (Vector* v : {&y_, &stage_y_, &stage_rate_}) v->resize(system.dim());
        for (Moments* m : {&Q_, &V_, &A_, &R_, &past_q_, &past_v_})
            for (Vector& v : *m) v.resize(dim_);
        for (Vector& v : past_sum_) v.resize(sums_);
        const double body = 2 * q.robot.l * q.robot.n;
        for (int j = 0; j < dim_; ++j) {
            mass_[j] = model_.mass(j);
            unit_[j] = model_.is_angle(j) ? 1.0 : body;
        }
        frequency_ = std::sqrt(q.spring.k / q.robot.m);
        ring_ = std::max(frequency_ / body, std::sqrt(q.spring.k / model_.lightest_turn()));
        // so long a step may miss a beat of the gait between its stages
        longest_ = 1.5 / q.gait.omega;
    }

    void restart(double t, const double* y) override {
        t_ = t, last_ = 0;
        std::copy_n(y, y_.size(), y_.begin());
        std::copy_n(y + 2 * dim_, sums_, sum_.begin());
        model_.enter(t);
        model_.load(t, y, q_.data(), v_.data());
        model_.at(0, t);
    }

    StepOutcome step(double t_limit) override {
        const char* why = kNoConvergence;
        again_ = last_ == 0;
        for (int tries = 0; tries < kMostTries; ++tries) {
            const bool last = t_ + 1.01 * h_ >= t_limit;
            const double h = last ? t_limit - t_ : h_;
            if (!(t_ + h > t_)) break;
            const bool solved = solve_stages(h);
            if (tolerance_ <= 0) return accept(h), StepOutcome{solved, why};
            error_ = solved ? estimate(h) : 0;
            if (solved && error_ <= tolerance_) {
                const double next = h * factor(h);
                h_ = last ? std::max(h_, next) : next;
                accept(h);
                return {};
            }
            why = solved ? kNoAccuracy : kNoConvergence;
            h_ = h * (solved ? std::min(0.9, factor(h)) : 0.25);
            again_ = true;
        }
        return {false, why};
    }

    double time() const override { return t_; }
    const double* state() const override { return y_.data(); }
    int dense_order() const override { return 3; }
    double local_error() const override { return error_; }

    // Through the stages: of order 3, as the error estimate is.
    void dense(double t, double* y) const override {
        const Weights w = weights((t - from_) / last_);
        for (int j = 0; j < dim_; ++j)
            dense_q_[j] = mean(w, past_q_, j), dense_v_[j] = mean(w, past_v_, j);
        model_.store(t, dense_q_.data(), dense_v_.data(), y);
        for (int j = 0; j < sums_; ++j) y[2 * dim_ + j] = mean(w, past_sum_, j);
    }

  private:
    // Of the polynomial through the start and the stages.
    static Weights weights(double x) {
        const Triple<double> w = kRadau.rule.dense(x);
        return {1 - w[0] - w[1] - w[2], w[0], w[1], w[2]};
    }

    static double mean(const Weights& w, const Moments& m, int j) {
        return w[0] * m[0][j] + w[1] * m[1][j] + w[2] * m[2][j] + w[3] * m[3][j];
    }

    // By how much the next step may be longer; after a good step in the light of the one before
    // (Gustafsson).
    double factor(double h) {
        const double slow = static_cast<double>(iterations_) / (2 * kMostIterations + iterations_);
        const double error = std::max(error_, 1e-4 * tolerance_);
        double f = 0.95 * (1 - slow) * std::pow(tolerance_ / error, 0.25);
        if (error_ <= tolerance_) {
            if (last_ > 0) f = std::min(f, f * (h / last_) * std::pow(before_ / error, 0.25));
            if (again_ && last_ > 0) f = std::min(f, 1.0);
            before_ = error;
        }
        return std::clamp(f, 0.125, std::min(8.0, std::max(1.0, longest_ / h)));
    }

    void accept(double h) {
        if (sums_ > 0) integrate_sums(h);
        from_ = t_, t_ += h, last_ = h;
        Q_[0] = q_, V_[0] = v_;
        past_q_.swap(Q_), past_v_.swap(V_);
        q_ = past_q_[3], v_ = past_v_[3];
        model_.keep_last_moment();
        model_.store(t_, q_.data(), v_.data(), y_.data());
        std::copy_n(sum_.begin(), sums_, y_.begin() + 2 * dim_);
    }

    // What the system integrates beside the motion (energies), by the quadrature of the stages.
    void integrate_sums(double h) {
        past_sum_[0] = sum_;
        for (int i = 1; i < kMoments; ++i) past_sum_[i] = sum_;
        for (int k = 0; k < 3; ++k) {
            const double t = t_ + kRadau.rule.c[k] * h;
            model_.store(t, Q_[k + 1].data(), V_[k + 1].data(), stage_y_.data());
            system_.rate(t, stage_y_.data(), stage_rate_.data());
            for (int i = 0; i < 3; ++i)
                for (int j = 0; j < sums_; ++j)
                    past_sum_[i + 1][j] += h * kRadau.rule.a[3 * i + k] * stage_rate_[2 * dim_ + j];
        }
        sum_ = past_sum_[3];
    }

    bool solve_stages(double h) {
        s_ = kRadau.gamma / h, pair_s_ = (1 / h) * kRadau.lambda;
        for (int i = 0; i < 3; ++i) model_.at(i + 1, t_ + kRadau.rule.c[i] * h);
        predict(h);
        set_stages();
        model_.linearize(2, Q_[2].data(), V_[2].data(), q_.data());
        model_.assemble(s_, real_);
        model_.assemble(pair_s_, pair_);
        return real_.factor() && pair_.factor() && newton();
    }

    // Stage rates as the last step's polynomial continues them, and the places they lead to.
    void predict(double h) {
        std::array<Weights, 3> w;
        for (int i = 0; i < 3; ++i)
            w[i] = last_ > 0 ? weights(1 + kRadau.rule.c[i] * h / last_) : Weights{};
        const Complex unpair = reciprocal(pair_s_);
        for (int j = 0; j < dim_; ++j) {
            Triple<double> V;
            for (int i = 0; i < 3; ++i) V[i] = last_ > 0 ? mean(w[i], past_v_, j) : v_[j];
            z_[j] = dot(kRadau.left, V) / s_;
            pair_z_[j] = unpair * dot(kRadau.left_pair, V);
        }
    }

    // Places, rates and accelerations of the stages.
    void set_stages() {
        const double one = kRadau.left[0] + kRadau.left[1] + kRadau.left[2];
        const Complex ones = kRadau.left_pair[0] + kRadau.left_pair[1] + kRadau.left_pair[2];
        for (int j = 0; j < dim_; ++j) {
            const double z = z_[j], v = s_ * z, a = s_ * (v - one * v_[j]);
            const Complex pz = pair_z_[j], pv = pair_s_ * pz, pa = pair_s_ * (pv - v_[j] * ones);
            for (int i = 0; i < 3; ++i) {
                const auto at_stage = [i](double own, Complex pair) {
                    const Complex p = kRadau.right_pair[i];
                    return kRadau.right[i] * own + 2 * (p.re * pair.re - p.im * pair.im);
                };
                Q_[i + 1][j] = q_[j] + at_stage(z, pz);
                V_[i + 1][j] = at_stage(v, pv), A_[i + 1][j] = at_stage(a, pa);
            }
        }
    }

    // Simplified Newton iteration. It stops when what is left is small against the tolerance, by
    // the worse of the last two rates of contraction: they alternate.
    bool newton() {
        const double enough = tolerance_ > 0 ? 0.03 * tolerance_ : 1e-13;
        double before = 0, rate = 0.5;
        for (iterations_ = 1; iterations_ <= kMostIterations; ++iterations_) {
            const double move = iterate();
            set_stages();
            if (!(move < 1e300)) return false;
            const double now = iterations_ > 1 ? move / before : 0.5;
            const double worst = std::max(rate, now);
            if (move == 0 || (worst < 1 && move * worst / (1 - worst) <= enough)) return true;
            if (iterations_ > 2 && worst >= 1) return tolerance_ <= 0 && move < 1e-9;  // rounding
            before = move, rate = iterations_ > 1 ? now : 0;
        }
        return tolerance_ <= 0;
    }

    // One iteration; returns how far the rates or places moved, in their units.
    double iterate() {
        for (int i = 1; i < kMoments; ++i)
            model_.residual(i, Q_[i].data(), V_[i].data(), A_[i].data(), R_[i].data());
        for (int j = 0; j < dim_; ++j) {
            const Triple<double> R{-R_[1][j], -R_[2][j], -R_[3][j]};
            dz_[j] = dot(kRadau.left, R), pair_dz_[j] = dot(kRadau.left_pair, R);
        }
        real_.solve(dz_.data());
        pair_.solve(pair_dz_.data());
        double move = 0;
        for (int j = 0; j < dim_; ++j)
            move = std::max(move, (std::fabs(dz_[j]) + 2 * size(pair_dz_[j])) / unit_[j]);
        model_.drop(dz_.data());
        model_.drop(pair_dz_.data());
        for (int j = 0; j < dim_; ++j) z_[j] += dz_[j], pair_z_[j] += pair_dz_[j];
        return move * std::max(1.0, s_ / unit_rate_);
    }

    double estimate(double h) {
        double error = filtered(h, q_, v_);
        if (again_ && error > tolerance_) {  // no smooth past: filter twice
            for (int j = 0; j < dim_; ++j) eq_[j] += q_[j], ev_[j] += v_[j];
            error = filtered(h, eq_, ev_);
        }
        error = std::max(error, ringing(h));
        return std::isfinite(error) ? error : 1e300;
    }

    // |(s - J)^-1 (y_0' + sum error_i (Y_i - y_0)/h)| with y_0' taken at (q, v); as tangent vectors
    // in eq_, ev_ on the way, as changes of q, v at the end.
    double filtered(double h, const Vector& q, const Vector& v) {
        Vector &slip = dz_, &push = A_[0];
        for (int j = 0; j < dim_; ++j) {
            double places = 0, rates = 0;
            for (int i = 0; i < 3; ++i) {
                places += kRadau.error[i] / h * (Q_[i + 1][j] - q_[j]);
                rates += kRadau.error[i] / h * (V_[i + 1][j] - v_[j]);
            }
            slip[j] = v[j] + places, push[j] = -rates;
        }
        model_.residual(0, q.data(), v.data(), push.data(), f_.data());
        model_.lift(slip.data());
        for (int j = 0; j < dim_; ++j) f_[j] = mass_[j] * s_ * slip[j] - f_[j];
        model_.subtract_damping(slip.data(), f_.data());
        real_.solve(f_.data());
        double error = 0;
        for (int j = 0; j < dim_; ++j) {
            eq_[j] = f_[j], ev_[j] = s_ * f_[j] - slip[j];
            error = std::max(
                error, std::max(std::fabs(eq_[j]), std::fabs(ev_[j]) / unit_rate_) / unit_[j]);
        }
        model_.drop(eq_.data());
        model_.drop(ev_.data());
        return error;
    }

    // The springs' ringing that a long step swallows: by how much the gaps at its start stand off
    // the smooth curve through its stages. A quarter of a period later such a gap is a speed, so
    // it counts by its frequency. Short steps follow the ringing, and the embedded formula judges.
    double ringing(double h) const {
        double worst = 0;
        for (int j = 0; j < dim_; ++j) {
            if (!model_.is_gap(j)) continue;
            const Triple<double> stages{Q_[1][j], Q_[2][j], Q_[3][j]};
            worst = std::max(worst, std::fabs(q_[j] - dot(kRadau.rule.at0, stages)));
        }
        return ring_ / unit_rate_ * std::min(1.0, h * frequency_) * worst;
    }

    mutable Model model_;  // keeps a table for the time last asked of dense()
    System& system_;
    int dim_, sums_;
    double tolerance_, unit_rate_, h_, longest_ = 0, frequency_ = 0, ring_ = 0;
    typename Model::template Matrix<double> real_;
    typename Model::template Matrix<Complex> pair_;
    double t_ = 0, from_ = 0, last_ = 0;  // now; start and length of the last step
    double s_ = 0, error_ = 0, before_ = 0;
    Complex pair_s_;
    int iterations_ = 0;
    bool again_ = false;  // no smooth past: the first step, or a step tried again
    mutable Vector dense_q_, dense_v_;
    Vector q_, v_, z_, dz_, f_, eq_, ev_, mass_, unit_;
    std::vector<Complex> pair_z_, pair_dz_;
    Moments Q_, V_, A_, R_, past_q_, past_v_, past_sum_;
    Vector y_, stage_y_, stage_rate_, sum_;
};

}  // namespace

std::unique_ptr<Method> make_radau(const RunRequest& q, System& system) {
    if (q.drive == Drive::angle) return std::make_unique<Radau<SpringAngle>>(q, system);
    return std::make_unique<Radau<SpringTorque>>(q, system);
}

}  // namespace serpenoid
