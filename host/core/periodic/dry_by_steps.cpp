// Periodic state on dry ground by implicit steps: a secant method on the map of
// sticking_motion.hpp.
//
// The map takes (Vx, Vy, L) at phase 0 to its mirror image half a cycle later (a whole cycle later,
// as it is, for a gait that steers); three unknowns, so its derivative is measured by differences
// and then kept up to date by Broyden's rule. The whole is repeated with tighter steps until the
// speed stops changing: the last change is the error estimate.
#include "periodic/dry_by_steps.hpp"

#include <algorithm>
#include <cmath>

#include "body/sticking_motion.hpp"
#include "numerics/matrix_product.hpp"

namespace serpenoid {

namespace {

class HalfCycle {
  public:
    HalfCycle(const Robot& robot, const Ground& ground, const Gait& gait)
        : motion_(robot, ground, gait),
          span_(gait.offset == 0 ? M_PI : 2 * M_PI),
          flip_(gait.offset == 0 ? -1 : 1) {
        const double v = motion_.speed_scale();
        scale_ = {v, v, robot.n * robot.m * v * robot.n * robot.l};
        start_ = {0, 0, motion_.momentum(0, 0)};
        motion_.limit(3'000'000 / robot.n);  // half a second, for whatever is asked
    }

    // z: state over scale. False when the steps fail.
    bool apply(const Vec3& z, double tolerance, Vec3& image) {
        end_ = at(z);
        if (!motion_.advance(end_, 0, span_, tolerance)) return false;
        const double sign[3] = {1, flip_, flip_};
        for (int i = 0; i < 3; ++i) image[i] = sign[i] * end_.v[i] / scale_[i];
        return true;
    }

    // The map from z with place counted in axes that turn evenly, by `turn` on the whole; x and y
    // stay as they are when the steps fail.
    void arc(const Vec3& z, double turn, double tolerance, double& x, double& y) {
        DryState state = at(z);
        motion_.turn_axes(turn / span_);
        if (motion_.advance(state, 0, span_, tolerance))
            x = state.v[DryState::x], y = state.v[DryState::y];
        motion_.turn_axes(0);
    }

    // Integral of sum P_i^+ over the map from z, J; negative when the steps fail.
    double positive_work(const Vec3& z, double tolerance) {
        DryState state = at(z);
        double work = 0;
        return motion_.advance_with_power(state, 0, span_, tolerance, work) ? work : -1;
    }

    // What the joints' work was off then from what friction took, J.
    double work_missed() const {
        return std::fabs(motion_.net_work() - end_.v[DryState::dissipated]);
    }

    Vec3 rest() const {
        return {start_[0] / scale_[0], start_[1] / scale_[1], start_[2] / scale_[2]};
    }
    const DryState& end() const { return end_; }
    const Vec3& scale() const { return scale_; }
    double rate(double L) { return motion_.rate(L, 0); }
    double span() const { return span_; }

  private:
    DryState at(const Vec3& z) const {
        DryState state{};
        for (int i = 0; i < 3; ++i) state.v[i] = z[i] * scale_[i];
        return state;
    }

    DryMotion motion_;
    double span_, flip_;
    Vec3 scale_, start_;
    DryState end_;
};

double size(const Vec3& a) { return std::max({std::fabs(a[0]), std::fabs(a[1]), std::fabs(a[2])}); }

// Solves image(z) = z; keeps z and the measured derivative M of the image from one level to the
// next.
class FixedPoint {
  public:
    explicit FixedPoint(HalfCycle& map) : map_(map), z_(map.rest()) {}

    // Follow the motion until a cycle changes it little, or for so many cycles.
    bool wander(int cycles, double tolerance) {
        constexpr double kNear = 0.02;
        for (int i = 0; i < cycles; ++i) {
            Vec3 image, change;
            if (!map_.apply(z_, tolerance, image)) return false;
            ++evaluations;
            for (int k = 0; k < 3; ++k) change[k] = image[k] - z_[k];
            z_ = image;
            if (size(change) < kNear) break;
        }
        return true;
    }

    // Newton's method until the next step would be below `goal`. False when the steps fail or the
    // residual stalls. A step that does not bring the residual down is halved.
    bool solve(double tolerance, double goal) {
        if (!measured_ && !measure(tolerance)) return false;
        Vec3 r, step;
        if (!residual(z_, tolerance, r)) return false;
        for (int i = 0; i < 30; ++i) {
            if (!newton(r, step)) return false;
            last_step = size(step);
            if (last_step <= goal) return true;
            Vec3 next, trial;
            double part = 1;
            for (; part > 0.05; part /= 2) {
                for (int k = 0; k < 3; ++k) next[k] = z_[k] + part * step[k];
                if (!residual(next, tolerance, trial)) return false;
                if (size(trial) < size(r)) break;
            }
            if (part <= 0.05) {  // the derivative has lost the way
                if (!measure(tolerance)) return false;
                if (++lost_ > 6) return false;
                continue;
            }
            for (int k = 0; k < 3; ++k) step[k] *= part;
            broyden(step, r, trial);
            z_ = next, r = trial;
        }
        return false;
    }

    const Mat3& derivative() const { return M_; }

    // The derivative by central differences; false when the steps fail.
    bool derivative(double tolerance, double delta, Mat3& M) {
        for (int j = 0; j < 3; ++j) {
            Vec3 ahead = z_, behind = z_, up, down;
            ahead[j] += delta, behind[j] -= delta;
            if (!map_.apply(ahead, tolerance, up) || !map_.apply(behind, tolerance, down))
                return false;
            for (int i = 0; i < 3; ++i) M[3 * i + j] = (up[i] - down[i]) / (2 * delta);
        }
        evaluations += 6;
        return true;
    }

    const Vec3& point() const { return z_; }
    int evaluations = 0;
    double last_step = 0;  // of Newton's method, as a fraction of the speed scale

  private:
    bool measure(double tolerance) {
        Vec3 base, moved;
        const double delta = std::max(1e-6, std::sqrt(tolerance) * 0.1);
        if (!map_.apply(z_, tolerance, base)) return false;
        for (int j = 0; j < 3; ++j) {
            Vec3 z = z_;
            z[j] += delta;
            if (!map_.apply(z, tolerance, moved)) return false;
            for (int i = 0; i < 3; ++i) M_[3 * i + j] = (moved[i] - base[i]) / delta;
        }
        evaluations += 4;
        return measured_ = true;
    }

    bool residual(const Vec3& z, double tolerance, Vec3& r) {
        Vec3 image;
        if (!map_.apply(z, tolerance, image)) return false;
        ++evaluations;
        for (int k = 0; k < 3; ++k) r[k] = image[k] - z[k];
        return true;
    }

    // After a step the residual went from r to r_new: M then maps the step to r_new - r + step.
    void broyden(const Vec3& step, const Vec3& r, const Vec3& r_new) {
        const Vec3 predicted = multiply(M_, step);
        double norm = 0;
        for (const double v : step) norm += v * v;
        if (norm == 0) return;
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
                M_[3 * i + j] += (r_new[i] - r[i] + step[i] - predicted[i]) * step[j] / norm;
    }

    bool newton(const Vec3& r, Vec3& step) const {
        Mat3 A = identity3();
        for (int i = 0; i < 9; ++i) A[i] -= M_[i];
        step = r;
        return solve_dense<3, 1>(A.data(), step.data()) && std::isfinite(size(step));
    }

    HalfCycle& map_;
    Vec3 z_;
    Mat3 M_{};
    bool measured_ = false;
    int lost_ = 0;
};

// The derivative over a period, in the units of the state.
Mat3 monodromy(const HalfCycle& map, Mat3 M, bool mirrored) {
    const Vec3& scale = map.scale();
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) M[3 * i + j] *= scale[i] / scale[j];
    return mirrored ? multiply(M, M) : M;
}

// Measured again from both sides, at two distances, as the secant method's derivative goes astray;
// below what the steps' own errors make of it a multiplier cannot be told from nothing.
void measure_multipliers(HalfCycle& map, FixedPoint& fixed, bool mirrored, double tolerance,
                         SteadyState& out) {
    const double near = std::max(1e-5, 0.3 * std::sqrt(tolerance));
    Mat3 M, wide;
    if (!fixed.derivative(tolerance, near, M) || !fixed.derivative(tolerance, 3 * near, wide))
        return;
    out.monodromy = monodromy(map, M, mirrored);
    out.slowest = log_spectral_radius(out.monodromy);
    const double noise = 10 * tolerance / near, seen = std::exp(out.slowest / (mirrored ? 2 : 1));
    const double other = log_spectral_radius(monodromy(map, wide, mirrored));
    out.slowest_error = out.slowest == other ? 0 : std::fabs(out.slowest - other);
    out.slowest_error += (mirrored ? 2 : 1) * std::log1p(noise / (seen + 1e-300));
}

void report(HalfCycle& map, const FixedPoint& fixed, const Gait& gait, double tolerance,
            SteadyState& out) {
    const auto v = map.end().v;
    double x = v[DryState::x], y = v[DryState::y], turn = v[DryState::theta];
    const bool mirrored = gait.offset == 0;
    const double time = map.span() / gait.omega;
    const Vec3 &z = fixed.point(), &scale = map.scale();
    if (mirrored) {
        const double c = std::cos(turn), s = std::sin(turn), mx = c * x + s * y, my = s * x - c * y;
        x += mx, y += my, turn = 0;
    }
    out.chord = std::hypot(x, y) * gait.omega / (2 * M_PI);
    if (!mirrored) map.arc(z, turn, tolerance, x, y);
    out.monodromy = monodromy(map, fixed.derivative(), mirrored);
    out.slowest = log_spectral_radius(out.monodromy);
    out.speed = std::hypot(x, y) * gait.omega / (2 * M_PI);
    out.direction = std::atan2(y, x);
    out.turn = turn;
    out.power = v[DryState::dissipated] / time;
    out.start = {z[0] * scale[0], z[1] * scale[1], map.rate(z[2] * scale[2])};
    out.iterations = fixed.evaluations;
}

// One level: the periodic state at a tolerance, held against that of the level before. False when
// the steps fail.
bool level(HalfCycle& map, FixedPoint& fixed, const Gait& gait, const SteadyOptions& options,
           double tolerance, const SteadyState& coarse, SteadyState& out) {
    Vec3 image;
    if (!fixed.solve(tolerance, std::max(3 * tolerance, 1e-12))) return false;
    if (!map.apply(fixed.point(), tolerance, image)) return false;
    report(map, fixed, gait, tolerance, out);
    if (options.powers) {
        const double work = map.positive_work(fixed.point(), tolerance);
        if (work < 0) return false;
        out.positive_power = work * gait.omega / map.span();
        out.abs_power = 2 * out.positive_power - out.power;
    }
    out.slowest_error = std::fabs(out.slowest);
    out.power_error = std::fabs(out.power - coarse.power);
    out.turn_error = std::fabs(out.turn - coarse.turn) + 3 * fixed.last_step;
    out.positive_power_error = std::fabs(out.positive_power - coarse.positive_power);
    if (options.powers) out.positive_power_error += map.work_missed() * gait.omega / map.span();
    return true;
}

}  // namespace

SteadyState steady_dry_by_steps(const Robot& robot, const Ground& ground, const Gait& gait,
                                const SteadyOptions& options) {
    HalfCycle map(robot, ground, gait);
    FixedPoint fixed(map);
    SteadyState out;
    out.speed_error = out.power_error = out.positive_power_error = out.turn_error =
        HUGE_VAL;  // nothing known yet
    const double floor = options.rtol * 1e-4 * gait.omega * 2 * robot.l * robot.n;
    if (!fixed.wander(200, 1e-3)) return out;
    double before = 0, reached = 0;
    for (double tolerance = 1e-4; tolerance > 1e-11; tolerance *= 0.03) {
        SteadyState next = out;
        if (!level(map, fixed, gait, options, tolerance, out, next)) break;
        // the last change, and what a lucky one would hide: part of the one before, Newton's rest
        const double change = std::fabs(next.speed - out.speed);
        next.speed_error = change + 0.03 * before + fixed.last_step * map.scale()[0];
        before = reached > 0 ? change : 0;
        next.converged = reached > 0 &&
                         next.speed_error <= std::max(options.rtol * next.speed, floor) &&
                         std::max(next.power_error, next.positive_power_error) <=
                             10 * options.rtol * std::max(next.power, next.positive_power) + 1e-300;
        out = next, reached = tolerance;
        if (out.converged) break;
    }
    if (reached > 0) measure_multipliers(map, fixed, gait.offset == 0, reached, out);
    return out;
}

}  // namespace serpenoid
