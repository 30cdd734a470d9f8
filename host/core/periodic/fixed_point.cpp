// The damped steps of fixed_point.hpp.
#include "periodic/fixed_point.hpp"

#include <algorithm>
#include <cmath>

namespace serpenoid {

namespace {

double size(const Vec3& a) { return std::max({std::fabs(a[0]), std::fabs(a[1]), std::fabs(a[2])}); }

// The inner product of the kinetic energy, but for a factor: friction draws motions together in it.
double inner(const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] / 12; }

// Newton's steps, in units of the scales. With these one of 600 dry gaits of 3 to 12 links, with
// friction over decades, is lost at a tolerance of 1e-4.
struct NewtonSteps {
    int max_iterations = 40;
    double first_length = 2;      // longest first step
    double lengthening = 3;       // of the longest step, after a limited one that helped
    double shortest_part = 0.01;  // of a step: a shorter one does not help
    double min_cut = 0.1;         // parts of a step between which the secant cuts it at once
    double max_cut = 0.5;
    double below_goal = 0.1;      // of the goal: a residual there is rounding
    double first_damping = 1e-6;  // of the one that alone would make a step so short
    double more_damping = 4;      // a damping over the one before
    double promising = 1e-3;      // a cycle's change, where Newton's method may do at once
    int cycles = 4;               // followed where no part of a step helps
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

// Follow from the start: the residual and the image's derivative.
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

// (1 + damping - M)^-1 residual.
bool FixedPoint::step(const Orbit& orbit, double damping, Vec3& d) const {
    Mat3 A = identity3();
    for (int i = 0; i < 9; ++i) A[i] = (1 + damping) * A[i] - orbit.derivative[i];
    d = orbit.residual;
    return solve_dense<3, 1>(A.data(), d.data()) && std::isfinite(size(d));
}

// Limit the step to `max_size`, and keep it from going against the residual, by damping: it makes
// the step shorter and turns it towards the residual. True where Newton's step was changed.
bool FixedPoint::shorten(const Orbit& orbit, double max_size, Vec3& d) const {
    const Vec3& r = orbit.residual;
    const auto fits = [&] { return size(d) <= max_size && inner(r, d) >= 0; };
    if (fits()) return false;
    for (double damping = kNewtonSteps.first_damping * size(r) / max_size; damping < 1;
         damping *= kNewtonSteps.more_damping)
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

// Where every wheel slides one way all the cycle through friction hardly depends on the speed: the
// residual is the same over a wide stretch, 1 - M next to singular, and Newton's step far too long.
// So a step is limited. Friction draws motions together, so the fixed point lies on the side to
// which the residual points. If the residual still points forward at the end of a step, the step
// is accepted and the next may be longer. A step that went too far is cut by the secant. When that
// does not help, a few cycles are followed.
FixedPoint::Ended FixedPoint::solve(double tolerance, double goal, bool work, Orbit& orbit) {
    Vec3 last_start = start, last_step{};
    double last_size = HUGE_VAL, part = 1, max_size = kNewtonSteps.first_length, progress_begin = 0;
    bool limited = false;
    for (int i = 0; i < kNewtonSteps.max_iterations; ++i) {
        const bool with_work = work && (i > 0 || start_solved || promising_);
        if (!evaluate({tolerance, with_work}, orbit)) return Ended::broken;
        const double residual = size(orbit.residual);
        const double progress = inner(orbit.residual, last_step);
        if (residual > last_size && residual > kNewtonSteps.below_goal * goal && !(progress > 0)) {
            part *= std::clamp(progress_begin / (progress_begin - progress), kNewtonSteps.min_cut,
                               kNewtonSteps.max_cut);
            start = last_start;
            if (part > kNewtonSteps.shortest_part) {
                for (int k = 0; k < 3; ++k) start[k] += part * last_step[k];
                max_size = part * size(last_step);
            } else {
                last_size = HUGE_VAL;
                part = 1;
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
        if (part == 1 && limited) max_size *= kNewtonSteps.lengthening;
        limited = shorten(orbit, max_size, d);
        last_size = residual;
        last_start = start;
        last_step = d;
        part = 1;
        progress_begin = inner(orbit.residual, d);
        for (int k = 0; k < 3; ++k) start[k] += d[k];
    }
    return Ended::stalled;
}

}  // namespace serpenoid
