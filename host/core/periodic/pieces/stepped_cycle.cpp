// Steps and measured derivatives of stepped_cycle.hpp.
#include "periodic/pieces/stepped_cycle.hpp"

#include <algorithm>
#include <cmath>

namespace serpenoid {

SteppedCycle::SteppedCycle(const Robot& robot, const Ground& ground, const Gait& gait,
                           long most_systems)
    : CycleMap(robot, gait), motion_(robot, ground, gait) {
    motion_.limit(most_systems);
}

namespace {

DryState state_of(const Vec3& p, double nm) {
    DryState state{};
    state.v[DryState::Vx] = p[0] / nm, state.v[DryState::Vy] = p[1] / nm;
    state.v[DryState::L] = p[2];
    return state;
}

}  // namespace

std::optional<SteppedCycle::Rows> SteppedCycle::run(const Vec3& p, const Following& how,
                                                    double* positive) {
    DryState state = state_of(p, nm_);
    motion_.turn_axes(how.spin);
    const bool done = positive
                          ? motion_.advance_with_power(state, 0, span(), how.tolerance, *positive)
                          : motion_.advance(state, 0, span(), how.tolerance);
    motion_.turn_axes(0);
    if (!done) return {};
    const auto& v = state.v;
    return Rows{nm_ * v[DryState::Vx],  nm_ * v[DryState::Vy], v[DryState::L],
                v[DryState::theta],     v[DryState::x],        v[DryState::y],
                v[DryState::dissipated]};
}

// By forward differences.
bool SteppedCycle::measure(const Vec3& p, const Rows& end, double tolerance) {
    const double part = std::max(1e-6, 0.1 * std::sqrt(tolerance));
    for (int j = 0; j < 3; ++j) {
        Vec3 beside = p;
        beside[j] += part * scale_[j];
        const auto moved = run(beside, {tolerance});
        if (!moved) return false;
        for (int i = 0; i < kRows; ++i)
            by_start_[i][j] = ((*moved)[i] - end[i]) / (part * scale_[j]);
    }
    return measured_ = true;
}

// Broyden's rule after a step of the start: the rows then give the change of the end that was seen.
// A step that is hardly longer than the errors of both ends tells nothing of the derivative. False
// where the old derivative was astray.
bool SteppedCycle::update(const Vec3& p, const Rows& end, double tolerance) {
    constexpr double kAstray = 0.3;  // of the step
    constexpr double kLeast = 100;   // errors
    const double error = std::max(tolerance, last_tolerance_);
    Vec3 step;
    double norm = 0, missed = 0;
    for (int k = 0; k < 3; ++k) {
        step[k] = (p[k] - last_p_[k]) / scale_[k];
        norm += step[k] * step[k];
    }
    if (std::sqrt(norm) < kLeast * error) return true;
    for (int i = 0; i < kRows; ++i) {
        double change = end[i] - last_end_[i];
        for (int k = 0; k < 3; ++k) change -= by_start_[i][k] * step[k] * scale_[k];
        if (i < 3) missed = std::max(missed, std::fabs(change) / scale_[i]);
        for (int k = 0; k < 3; ++k) by_start_[i][k] += change * step[k] / norm / scale_[k];
    }
    return missed <= kAstray * std::sqrt(norm);
}

std::optional<CycleEnd> SteppedCycle::follow(const Vec3& p, const Following& how) {
    double positive = 0;
    const auto end = run(p, how, how.work ? &positive : nullptr);
    if (!end) return {};
    CycleEnd to;
    to.state.p = {(*end)[0], (*end)[1], (*end)[2]};
    to.state.theta = (*end)[3], to.state.x = (*end)[4], to.state.y = (*end)[5];
    to.state.dissipated = (*end)[6];
    if (how.work) to.work = {{positive}, motion_.net_work()};
    if (!how.derivative) return to;
    if (!measured_ || !update(p, *end, how.tolerance))
        if (!measure(p, *end, how.tolerance)) return {};
    last_p_ = p, last_end_ = *end, last_tolerance_ = how.tolerance;
    to.state.by_start = by_start_;
    return to;
}

std::optional<Mat3> SteppedCycle::measured_derivative(const Vec3& p, const Following& how,
                                                      double distance) {
    Mat3 M;
    for (int j = 0; j < 3; ++j) {
        Vec3 ahead = p, behind = p;
        ahead[j] += distance * scale_[j], behind[j] -= distance * scale_[j];
        const auto up = run(ahead, how), down = run(behind, how);
        if (!up || !down) return {};
        for (int i = 0; i < 3; ++i)
            M[3 * i + j] = ((*up)[i] - (*down)[i]) / (2 * distance * scale_[j]);
    }
    return M;
}

}  // namespace serpenoid
