// Newton's method of fixed_point.hpp, with limited and damped steps.
#include "periodic/fixed_point.hpp"

#include <algorithm>
#include <cmath>

namespace serpenoid {

namespace {

double size(const Vec3& a) { return std::max({std::fabs(a[0]), std::fabs(a[1]), std::fabs(a[2])}); }

// The inner product that belongs to kinetic energy, except for a factor. In its norm, friction
// reduces the distance of two motions.
double inner(const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] / 12; }

// Tuning of Newton's steps, in units of the scales. With these values the search fails for one of
// 600 dry gaits of 3 to 12 links, with friction over decades, at a tolerance of 1e-4.
struct NewtonSteps {
    int max_iterations = 40;
    double first_length = 2;     // limit of the first step
    double growth = 3;           // growth of the limit after a limited step that succeeded
    double min_fraction = 0.01;  // least fraction of a step that is tried
    double min_cut = 0.1;        // least and greatest factor by which the secant cuts a step
    double max_cut = 0.5;
    double rounding = 0.1;        // residual, over the goal, that counts as rounding
    double first_damping = 1e-6;  // first damping, over the one that limits the step by itself
    double damping_growth = 4;    // ratio of one damping to the last
    double promising = 1e-3;      // change in a cycle below which one Newton step may suffice
    int cycles = 4;               // cycles followed if no fraction of a step succeeds
};
constexpr NewtonSteps kNewtonSteps;

}  // namespace

double Orbit::extrapolate(double value, int row, const Vec3& scale) const {
    for (int k = 0; k < 3; ++k) value += end.state.by_start[row][k] * step[k] * scale[k];
    return value;
}

double Orbit::sensitivity(int row, const Vec3& scale) const {
    double sum = 0;
    for (int k = 0; k < 3; ++k) sum += std::fabs(end.state.by_start[row][k]) * scale[k];
    return sum;
}

double Orbit::condition() const {
    Mat3 A = identity3(), inverse = identity3();
    for (int i = 0; i < 9; ++i) A[i] -= derivative[i];
    if (!solve_dense<3, 3>(A.data(), inverse.data())) return HUGE_VAL;
    double norm = 0;
    for (int i = 0; i < 3; ++i)
        norm = std::max(norm, std::fabs(inverse[3 * i]) + std::fabs(inverse[3 * i + 1]) +
                                  std::fabs(inverse[3 * i + 2]));
    return norm;
}

// Follow the motion from the start; set the residual, and the derivative of the end's image.
bool FixedPoint::evaluate(const Following& how, Orbit& orbit) {
    const Vec3 &scale = map_.scale(), sign = mirror_signs(map_.mirrored());
    Vec3 p;
    for (int k = 0; k < 3; ++k) p[k] = start[k] * scale[k];
    std::optional<CycleEnd> end = map_.follow(p, how);
    if (!end) return false;
    orbit.start = start;
    orbit.end = std::move(*end);
    const CycleState& state = orbit.end.state;
    for (int i = 0; i < 3; ++i) {
        orbit.residual[i] = (sign[i] * state.p[i] - p[i]) / scale[i];
        for (int j = 0; j < 3; ++j)
            orbit.derivative[3 * i + j] = sign[i] * state.by_start[i][j] * (scale[j] / scale[i]);
    }
    return true;
}

// d = (1 + damping - M)^-1 residual; false if the matrix is singular.
bool FixedPoint::step(const Orbit& orbit, double damping, Vec3& d) const {
    Mat3 A = identity3();
    for (int i = 0; i < 9; ++i) A[i] = (1 + damping) * A[i] - orbit.derivative[i];
    d = orbit.residual;
    return solve_dense<3, 1>(A.data(), d.data()) && std::isfinite(size(d));
}

// Limit the step d to max_size, and its angle to the residual to 90 degrees, by damping, which
// shortens the step and turns it towards the residual. Whether the step was changed.
bool FixedPoint::shorten(const Orbit& orbit, double max_size, Vec3& d) const {
    const Vec3& r = orbit.residual;
    const auto fits = [&] { return size(d) <= max_size && inner(r, d) >= 0; };
    if (fits()) return false;
    for (double damping = kNewtonSteps.first_damping * size(r) / max_size; damping < 1;
         damping *= kNewtonSteps.damping_growth)
        if (step(orbit, damping, d) && fits()) return true;
    for (int k = 0; k < 3; ++k) d[k] = r[k] * std::min(1.0, max_size / size(r));
    return true;
}

bool FixedPoint::follow_cycles(int max_cycles, double settled, double tolerance, double share) {
    for (int i = 0; i < max_cycles; ++i, share = 1) {
        Orbit orbit;
        if (!evaluate({tolerance}, orbit)) return false;
        for (int k = 0; k < 3; ++k) start[k] += share * orbit.residual[k];
        const double change = share * size(orbit.residual);
        promising_ = change < kNewtonSteps.promising;
        if (change < settled) break;
    }
    return true;
}

// If no wheel changes its direction during the cycle, friction hardly depends on the speed. Then
// the residual is nearly constant in a wide region, 1 - M is nearly singular, and Newton's step is
// far too long; so steps are limited. Friction reduces the distance of motions, so the residual
// points towards the fixed point. If the residual at the end of a step has a positive product with
// the step, the step is accepted, and the next may be longer. A step that is too long is cut by the
// secant. If that fails, a few cycles are followed.
FixedPoint::Ended FixedPoint::solve(double tolerance, double goal, bool work, Orbit& orbit) {
    Vec3 last_start = start, last_step{};
    double last_size = HUGE_VAL, fraction = 1, max_size = kNewtonSteps.first_length,
           first_progress = 0;
    bool limited = false;
    for (int i = 0; i < kNewtonSteps.max_iterations; ++i) {
        const bool with_work = work && (i > 0 || start_solved || promising_);
        if (!evaluate({tolerance, with_work}, orbit)) return Ended::broken;
        const double residual = size(orbit.residual);
        const double progress = inner(orbit.residual, last_step);
        if (residual > last_size && residual > kNewtonSteps.rounding * goal && !(progress > 0)) {
            fraction *= std::clamp(first_progress / (first_progress - progress),
                                   kNewtonSteps.min_cut, kNewtonSteps.max_cut);
            start = last_start;
            if (fraction > kNewtonSteps.min_fraction) {
                for (int k = 0; k < 3; ++k) start[k] += fraction * last_step[k];
                max_size = fraction * size(last_step);
            } else {
                last_size = HUGE_VAL;
                fraction = 1;
                if (!follow_cycles(kNewtonSteps.cycles, goal, tolerance)) return Ended::broken;
            }
            continue;
        }
        Vec3 d;
        if (!step(orbit, 0, d)) return Ended::stalled;
        if (i == 0 && !start_solved) promising_ = size(d) <= 4 * goal;
        if (size(d) <= goal && with_work == work) {
            orbit.step = d;
            start = orbit.next_start();
            return Ended::converged;
        }
        if (fraction == 1 && limited) max_size *= kNewtonSteps.growth;
        limited = shorten(orbit, max_size, d);
        last_size = residual;
        last_start = start;
        last_step = d;
        fraction = 1;
        first_progress = inner(orbit.residual, d);
        for (int k = 0; k < 3; ++k) start[k] += d[k];
    }
    return Ended::stalled;
}

}  // namespace serpenoid
