// Changes of mode of dry_cycle.hpp: very short implicit steps that know none.
#include <algorithm>
#include <cmath>
#include <utility>

#include "periodic/dry_cycle.hpp"

namespace serpenoid {

// One implicit Euler step of `length` rad without a mode; node 0 of the piece is filled at its end.
// Wheels of a straight chain have one and the same kink, where an active-set method could cycle:
// each kink is moved by its own 1e-13 or less of the speed scale.
bool DryCycle::kick(CycleState& state, double& tau, double tau_end, double length) {
    const double dtau = std::min(length, tau_end - tau), h = dtau / omega_;
    piece_.look(tau, tau + dtau);
    const Vec3 u0 = piece_.velocity(piece_.node(0), state.p);
    if (jump_.waits) {
        const WheelDirection g = piece_.row(jump_.wheel, 0);
        jump_.gradient = {jump_.sign * g.x / nm_, jump_.sign * g.y / nm_,
                          jump_.sign * g.r * piece_.node(0).iJ};
    }
    way_.clear();
    for (int c = 0; c < 2 * robot_.n; ++c)
        way_.push_back(piece_.row(c, 0).speed(u0.data(), omega_));
    piece_.weigh(way_);
    const SlidingPiece::Node& k = piece_.node(1);
    const double *D = k.D, speed = scale_[0] / nm_;
    const Mat3 H = {nm_ + h * D[0], h * D[1], h * D[2], h * D[1],      nm_ + h * D[3],
                    h * D[4],       h * D[2], h * D[4], k.J + h * D[5]};
    const double c = std::cos(h * u0[2]), n = std::sin(h * u0[2]);
    const Vec3 b = {c * state.p[0] + n * state.p[1] - h * (omega_ * k.d[0] + k.dry[0]),
                    c * state.p[1] - n * state.p[0] - h * (omega_ * k.d[1] + k.dry[1]),
                    state.p[2] - omega_ * k.K - h * (omega_ * k.d[2] + k.dry[2])};
    kinks_.clear(), wheel_of_kink_.clear();
    for (int wheel = 0; wheel < 2 * robot_.n; ++wheel) {
        if (!piece_.has_modes(wheel)) continue;
        const WheelDirection g = piece_.row(wheel, 1);
        kinks_.push_back({{g.x, g.y, g.r},
                          omega_ * g.e + 1e-13 * speed * apart_[kinks_.size()],
                          h * piece_.mu(wheel)});
        wheel_of_kink_.push_back(wheel);
    }
    if (!convex_.solve(H, b, kinks_)) {
        convex_.forget();
        if (!convex_.solve(H, b, kinks_)) return false;
    }
    const Vec3& u = convex_.minimum();
    state.p = {nm_ * u[0], nm_ * u[1], k.J * u[2] + omega_ * k.K};
    state.theta += h * u[2];
    const double heading = state.theta - spin_ * (tau + dtau);
    state.x += h * (std::cos(heading) * u[0] - std::sin(heading) * u[1]);
    state.y += h * (std::sin(heading) * u[0] + std::cos(heading) * u[1]);
    double watts = u[0] * (D[0] * u[0] + 2 * D[1] * u[1] + 2 * D[2] * u[2]) +
                   u[1] * (D[3] * u[1] + 2 * D[4] * u[2]) + D[5] * u[2] * u[2] +
                   2 * omega_ * (k.d[0] * u[0] + k.d[1] * u[1] + k.d[2] * u[2]) +
                   omega_ * omega_ * k.dd;
    for (std::size_t c = 0; c < kinks_.size(); ++c)
        watts += piece_.mu(wheel_of_kink_[c]) * std::fabs(kinks_[c].at(u)) -
                 piece_.thrust(wheel_of_kink_[c]) * kinks_[c].at(u);
    state.dissipated += h * watts;
    tau = dtau == tau_end - tau ? tau_end : tau + dtau;
    skipped_ += dtau;
    set_mode();
    settle_stuck(state);
    return true;
}

// Put the wheels that stick at rest to the last digit: what a kick leaves of their speeds, 1e-11 of
// the scale, would over a short piece be taken for a force. Node 1 of the piece is where the kick
// ended. Wheels of a straight chain have one and the same row: those stay as they are.
void DryCycle::settle_stuck(CycleState& state) {
    const SlidingPiece::Node& k = piece_.node(1);
    const double mass[3] = {nm_, nm_, k.J};
    const Vec3 u = piece_.velocity(k, state.p);
    Mat3 S = identity3();
    Vec3 pull{}, row[3]{};
    for (int a = 0; a < mode_.count; ++a) {
        const WheelDirection g = piece_.row(mode_.stuck[a], 1);
        row[a] = {g.x, g.y, g.r}, pull[a] = -g.speed(u.data(), omega_);
    }
    for (int a = 0; a < mode_.count; ++a)
        for (int b = 0; b < mode_.count; ++b) {
            S[3 * a + b] = 0;
            for (int i = 0; i < 3; ++i) S[3 * a + b] += row[a][i] * row[b][i] / mass[i];
        }
    if (mode_.count == 0 || !solve_dense<3, 1>(S.data(), pull.data())) return;
    Vec3 p = state.p;
    double moved = 0;
    for (int i = 0; i < 3; ++i) {
        for (int a = 0; a < mode_.count; ++a) p[i] += pull[a] * row[a][i];
        moved = std::max(moved, std::fabs(p[i] - state.p[i]) / scale_[i]);
    }
    if (moved < 1e-8) state.p = p;
}

void DryCycle::set_mode() {
    mode_.count = 0;
    for (std::size_t c = 0; c < kinks_.size(); ++c) {
        const int wheel = wheel_of_kink_[c];
        if (convex_.held(static_cast<int>(c)) && mode_.count < 3) {
            mode_.sign[wheel] = 0, mode_.stuck[mode_.count++] = wheel;
        } else {
            mode_.sign[wheel] = convex_.sign(static_cast<int>(c)) < 0 ? -1 : 1;
        }
    }
}

// Find the mode that follows the end of one.
bool DryCycle::change_mode(CycleState& state, double& tau, double tau_end, const Ending& end) {
    before_ = mode_.sign;
    if (!kick_on(state, tau, tau_end, end)) return false;
    if (end.wheel >= 0) note_changes();
    return true;
}

// The kick is lengthened until the wheel has changed, and from one end to the next when they come
// in quick succession: two wheels of an almost straight chain may take turns in stopping, for so
// short a time as cannot stop both.
bool DryCycle::kick_on(CycleState& state, double& tau, double tau_end, const Ending& end) {
    const CycleState before = state;
    const double skipped = skipped_, from = tau, was = end.wheel < 0 ? 2 : mode_.sign[end.wheel];
    double length = kick_ = std::clamp(4 * kick_, shortest_kick_, 10 * longest_kick_);
    for (int attempt = 0; attempt < 6; ++attempt) {
        state = before, tau = from, skipped_ = skipped;
        if (!kick(state, tau, tau_end, length)) return false;
        if (end.wheel < 0 || mode_.sign[end.wheel] != was || length >= longest_kick_) return true;
        length = std::min(8 * length, std::max(kick_, longest_kick_));
    }
    return true;
}

void DryCycle::note_changes() {
    int slid = 0;
    for (int c = 0; c < 2 * robot_.n; ++c) {
        if (mode_.sign[c] == before_[c]) continue;
        slid += before_[c] != 0, fresh_[c] = 1;
    }
    together_ = together_ || slid > 1;
}

}  // namespace serpenoid
