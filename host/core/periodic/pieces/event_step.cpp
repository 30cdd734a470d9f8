// The convex problem of event_step.hpp, and the mode that its solution shows.
#include "periodic/pieces/event_step.hpp"

#include <algorithm>
#include <cmath>

namespace serpenoid {

namespace {

constexpr double kMaxShift =
    1e-13;  // limit of the shifts of kinks, as a fraction of the speed scale

}  // namespace

EventStep::EventStep(const CycleMap& map, SlidingPiece& piece)
    : omega_(map.gait().omega), nm_(map.nm()), scale_(map.scale()), piece_(piece) {
    for (int c = 1; c <= piece.wheels(); ++c) shift_.push_back(std::fmod(0.6180339887 * c, 1.0));
}

// The wheels of a straight chain all have the same kink, for which an active-set method could
// cycle; so each kink gets another small shift. The wheel that stopped has a small speed beyond
// rest, and stuck wheels drift a little between the stages. The step would treat such a speed as
// the effect of a force, and a wheel near its bound might slide; so the kinks of these wheels are
// put at it.
void EventStep::set_kinks(double h, const SlidingMode& last_mode, const ModeEvent& event) {
    const double speed = scale_[0] / nm_;
    kinks_.clear();
    wheel_of_kink_.clear();
    for (int wheel = 0; wheel < piece_.wheels(); ++wheel) {
        if (!piece_.law(wheel).has_modes()) continue;
        const WheelDirection g = piece_.row(wheel, 1);
        const bool rests = event.wheel >= 0 && (last_mode.sign[wheel] == 0 || wheel == event.wheel);
        const double drift = rests ? direction_[wheel] : 0;
        kinks_.push_back({{g.x, g.y, g.r},
                          omega_ * g.e - drift + kMaxShift * speed * shift_[kinks_.size()],
                          h * piece_.law(wheel).bound()});
        wheel_of_kink_.push_back(wheel);
    }
}

// Find the velocity after h seconds, from momenta p and velocity u0.
bool EventStep::solve(const Vec3& p, const Vec3& u0, double h) {
    const SlidingPiece::Node& k = piece_.node(1);
    const double* D = k.D;
    const Mat3 H = {nm_ + h * D[0], h * D[1], h * D[2], h * D[1],      nm_ + h * D[3],
                    h * D[4],       h * D[2], h * D[4], k.J + h * D[5]};
    const double c = std::cos(h * u0[2]), n = std::sin(h * u0[2]);
    const Vec3 b = {c * p[0] + n * p[1] - h * (omega_ * k.d[0] + k.dry[0]),
                    c * p[1] - n * p[0] - h * (omega_ * k.d[1] + k.dry[1]),
                    p[2] - omega_ * k.K - h * (omega_ * k.d[2] + k.dry[2])};
    if (convex_.solve(H, b, kinks_)) return true;
    convex_.forget();
    return convex_.solve(H, b, kinks_);
}

// Power dissipated by friction at the end of the step, W.
double EventStep::dissipation(const Vec3& u) const {
    double watts = piece_.node(1).dissipation(u, omega_);
    for (std::size_t c = 0; c < kinks_.size(); ++c) {
        const WheelLaw& law = piece_.law(wheel_of_kink_[c]);
        const double v = kinks_[c].value(u);
        watts += law.bound() * std::fabs(v) - law.thrust() * v;
    }
    return watts;
}

bool EventStep::take(CycleState& state, double tau, double dtau, double spin,
                     const SlidingMode& last_mode, const ModeEvent& event, SlidingMode& mode) {
    const double h = dtau / omega_;
    piece_.set_nodes(tau, tau + dtau);
    const Vec3 u0 = piece_.velocity(piece_.node(0), state.p);
    direction_.clear();
    for (int wheel = 0; wheel < piece_.wheels(); ++wheel)
        direction_.push_back(piece_.row(wheel, 0).speed(u0.data(), omega_));
    piece_.sum_nodes(direction_);
    set_kinks(h, last_mode, event);
    if (!solve(state.p, u0, h)) return false;
    const Vec3& u = convex_.minimum();
    const SlidingPiece::Node& k = piece_.node(1);
    state.p = {nm_ * u[0], nm_ * u[1], k.J * u[2] + omega_ * k.K};
    state.theta += h * u[2];
    const double heading = state.theta - spin * (tau + dtau);
    state.x += h * (std::cos(heading) * u[0] - std::sin(heading) * u[1]);
    state.y += h * (std::sin(heading) * u[0] + std::cos(heading) * u[1]);
    state.dissipated += h * dissipation(u);
    set_mode(mode);
    put_at_rest(mode, state);
    return true;
}

void EventStep::set_mode(SlidingMode& mode) const {
    mode.count = 0;
    for (int kink = 0; kink < static_cast<int>(kinks_.size()); ++kink) {
        const int wheel = wheel_of_kink_[kink];
        if (convex_.holds(kink) && mode.count < 3) {
            mode.sign[wheel] = 0;
            mode.stuck[mode.count++] = wheel;
        } else {
            mode.sign[wheel] = convex_.sign(kink) < 0 ? -1 : 1;
        }
    }
}

// Bring the stuck wheels to rest except for rounding; otherwise the next piece, if short, would
// need a force to stop them. The wheels of a straight chain have equal rows; then nothing is
// changed.
void EventStep::put_at_rest(const SlidingMode& mode, CycleState& state) const {
    const Vec3 u = piece_.velocity(piece_.node(1), state.p);
    const Vec3 change = piece_.correction(1, mode, u);
    double size = 0;
    for (int i = 0; i < 3; ++i) size = std::max(size, std::fabs(change[i]) / scale_[i]);
    for (int i = 0; i < 3 && size < max_correction_; ++i) state.p[i] += change[i];
}

}  // namespace serpenoid
