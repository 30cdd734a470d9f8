// Newton's method and tolerances of dry.hpp.
#include "periodic/dry.hpp"

#include <algorithm>
#include <cmath>

#include "numerics/matrix_product.hpp"
#include "periodic/dry_by_steps.hpp"

namespace serpenoid {

namespace {

constexpr int kTurn = 3, kDissipated = 6;  // rows of CycleState's derivative

// Of which nothing is known yet.
SteadyState unknown() {
    SteadyState s;
    s.speed_error = s.power_error = s.positive_power_error = s.turn_error = HUGE_VAL;
    return s;
}

// Where wheels that rest leave next to nothing of a disturbance, what is left is rounding: then a
// multiplier is known to be small, but not how small.
SteadyState within_rounding(SteadyState s) {
    constexpr double kLeast = -30;  // of its logarithm
    if (s.slowest < kLeast) s.slowest = kLeast, s.slowest_error = -kLeast;
    return s;
}

double size(const Vec3& a) { return std::max({std::fabs(a[0]), std::fabs(a[1]), std::fabs(a[2])}); }

// In which motions draw together, but for a factor: that of the kinetic energy.
double inner(const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] / 12; }

constexpr double kReach = 2;  // of the first step, in units of the scales

// Of two logarithms, either of which may be that of zero.
double change_of(double a, double b) { return a == b ? 0 : std::fabs(a - b); }

}  // namespace

// The mirror image of the end less the start, over the scales, and its derivative.
void SteadyDry::image(const CycleState& end, Vec3& r) {
    const double flip = gait_.offset == 0 ? -1 : 1, sign[3] = {1, flip, flip};
    for (int i = 0; i < 3; ++i) {
        r[i] = sign[i] * end.p[i];
        for (int j = 0; j < 3; ++j) M_[3 * i + j] = sign[i] * end.by_start[i][j];
    }
}

bool SteadyDry::step(const Vec3& r, Vec3& d, double lag) const {
    Mat3 A = identity3();
    for (int i = 0; i < 9; ++i) A[i] = (1 + lag) * A[i] - M_[i];
    d = r;
    return solve_dense<3, 1>(A.data(), d.data()) && std::isfinite(size(d));
}

// A step no longer than `reach` and not against the residual: the more `lag` is added to 1 - M, the
// shorter it is and the more it follows the residual, so that what settles fast still does. True
// where Newton's step was not such a one.
bool SteadyDry::shorten(const Vec3& r, double reach, Vec3& d) const {
    const auto fits = [&] { return size(d) <= reach && inner(r, d) >= 0; };
    if (fits()) return false;
    for (double lag = 1e-6 * size(r) / reach; lag < 1; lag *= 4)
        if (step(r, d, lag) && fits()) return true;
    for (int k = 0; k < 3; ++k) d[k] = r[k] * std::min(1.0, reach / size(r));
    return true;
}

// How many times an error of the map moves its fixed point: the norm of (1 - M)^-1.
double SteadyDry::slackness() const {
    Mat3 A = identity3(), inverse = identity3();
    for (int i = 0; i < 9; ++i) A[i] -= M_[i];
    if (!solve_dense<3, 3>(A.data(), inverse.data())) return HUGE_VAL;
    double most = 0;
    for (int i = 0; i < 3; ++i)
        most = std::max(most, std::fabs(inverse[3 * i]) + std::fabs(inverse[3 * i + 1]) +
                                  std::fabs(inverse[3 * i + 2]));
    return most;
}

// Follow the motion until a cycle changes it little, or for so many cycles; share: of the first
// one's change that is made. Half of it, from rest: a fast gait's angular momentum hardly changes,
// but has its sign turned over by the mirror.
bool SteadyDry::wander(DryCycle& cycle, int most, double near, double tolerance, double share) {
    for (int i = 0; i < most; ++i, share = 1) {
        Vec3 p, r;
        for (int k = 0; k < 3; ++k) p[k] = z_[k] * cycle.scale()[k];
        if (!cycle.follow(p, span(), tolerance, 0, end_)) return false;
        image(end_, r);
        double change = 0;
        for (int k = 0; k < 3; ++k) {
            const double by = share * (r[k] / cycle.scale()[k] - z_[k]);
            change = std::max(change, std::fabs(by)), z_[k] += by;
        }
        promising_ = change < 1e-3;
        if (change < near) break;
    }
    return true;
}

// Where every wheel slides one way all the cycle through friction hardly hangs on the speed: the
// residual is the same over a wide stretch, 1 - M next to singular, and Newton's step far too long.
// So a step is at most `reach` long. Friction draws motions together, so that the fixed point lies
// on the side to which the residual points: a step at whose end the residual still points ahead is
// taken, though it be no smaller, and the next may be longer; one that has gone too far is cut by
// the secant. When that does not help, a few cycles are followed.
SteadyDry::Ended SteadyDry::newton(DryCycle& cycle, double tolerance, double goal, bool powers,
                                   SteadyState& out) {
    constexpr int kMost = 40;
    const Vec3& scale = cycle.scale();
    Vec3 last_z = z_, last_d{};
    double last = HUGE_VAL, part = 1, reach = kReach, before = 0;
    bool cut = false;
    for (int i = 0; i < kMost; ++i) {
        Vec3 p, r, d;
        for (int k = 0; k < 3; ++k) p[k] = z_[k] * scale[k];
        const bool watched = powers && (i > 0 || near_ || promising_);
        cycle.watch_powers(watched ? &positive_ : nullptr);
        const bool done = cycle.follow(p, span(), tolerance, 0, end_);
        cycle.watch_powers(nullptr);
        net_work_ = cycle.net_work(), doubtful_work_ = cycle.doubtful_work();
        together_ = cycle.together();
        if (!done) return Ended::broken;
        ++out.iterations;
        image(end_, r);
        for (int k = 0; k < 3; ++k) r[k] = (r[k] - p[k]) / scale[k];
        for (int a = 0; a < 3; ++a)
            for (int b = 0; b < 3; ++b) M_[3 * a + b] *= scale[b] / scale[a];
        const double now = size(r), ahead = inner(r, last_d);
        if (now > last && now > 0.1 * goal && !(ahead > 0)) {
            part *= std::clamp(before / (before - ahead), 0.1, 0.5);
            if (part > 0.01) {
                for (int k = 0; k < 3; ++k) z_[k] = last_z[k] + part * last_d[k];
                reach = part * size(last_d);
            } else {
                z_ = last_z, last = HUGE_VAL, part = 1;
                if (!wander(cycle, 4, goal, tolerance)) return Ended::broken;
            }
            continue;
        }
        if (!step(r, d)) return Ended::stalled;
        if (i == 0 && !near_) promising_ = size(d) <= 4 * goal;
        if (size(d) <= goal && watched == powers) {
            report(cycle, d, tolerance, out);
            for (int k = 0; k < 3; ++k) z_[k] += d[k];
            return Ended::converged;
        }
        if (part == 1 && cut) reach *= 3;
        cut = shorten(r, reach, d);
        last = now, last_z = z_, last_d = d, part = 1, before = inner(r, d);
        for (int k = 0; k < 3; ++k) z_[k] += d[k];
    }
    return Ended::stalled;
}

// Speed, turn and power at z + d: those of the motion from z, and what d changes by derivatives.
void SteadyDry::report(DryCycle& cycle, const Vec3& d, double tolerance, SteadyState& out) {
    const Vec3& scale = cycle.scale();
    const auto moved = [&](int row, double value) {
        for (int k = 0; k < 3; ++k) value += end_.by_start[row][k] * d[k] * scale[k];
        return value;
    };
    double x = moved(4, end_.x), y = moved(5, end_.y), turn = moved(3, end_.theta);
    const double time = span() / gait_.omega, nm = robot_.n * robot_.m;
    Mat3 M = M_;
    const double unit[3] = {scale[0] / nm, scale[1] / nm, scale[2]};
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) M[3 * i + j] *= unit[i] / unit[j];
    if (gait_.offset == 0) {  // the second half is the mirror image, seen from the heading then
        const double c = std::cos(turn), s = std::sin(turn), mx = c * x + s * y, my = s * x - c * y;
        x += mx, y += my, turn = 0, M = multiply(M, M);
        out.chord = std::hypot(x, y) * gait_.omega / (2 * M_PI);
    } else {
        out.chord = std::hypot(x, y) * gait_.omega / (2 * M_PI);
        Vec3 p;
        for (int k = 0; k < 3; ++k) p[k] = (z_[k] + d[k]) * scale[k];
        CycleState arc;
        if (cycle.follow(p, span(), tolerance, turn / (2 * M_PI), arc)) x = arc.x, y = arc.y;
    }
    out.speed = std::hypot(x, y) * gait_.omega / (2 * M_PI);
    out.direction = std::atan2(y, x), out.turn = turn;
    out.monodromy = M, out.slowest = log_spectral_radius(M);
    out.power = moved(6, end_.dissipated) / time;
    out.start = {(z_[0] + d[0]) * scale[0] / nm, (z_[1] + d[1]) * scale[1] / nm,
                 cycle.rate((z_[2] + d[2]) * scale[2], 0)};
}

// Sums over the joints; every joint's change from the level before counts as an error, and so does
// what the joints' net work is off from what friction took.
void SteadyDry::add_positive(std::vector<double>& before, SteadyState& out) const {
    const double rate = gait_.omega / span();
    before.resize(positive_.size());
    out.positive_power = 0;
    out.positive_power_error = (std::fabs(net_work_ - end_.dissipated) + doubtful_work_) * rate;
    for (std::size_t i = 0; i < positive_.size(); ++i) {
        out.positive_power += positive_[i] * rate;
        out.positive_power_error += std::fabs(positive_[i] - before[i]) * rate;
    }
    out.abs_power = 2 * out.positive_power - out.power;
    before = positive_;
}

SteadyDry::Changes SteadyDry::changes(const SteadyState& fine, const SteadyState& coarse) {
    return {std::fabs(fine.speed - coarse.speed), std::fabs(fine.power - coarse.power),
            change_of(fine.slowest, coarse.slowest)};
}

// The errors of a level, from the changes to it and to the one before, and beside them from that of
// the state and from what an error of the map moves it by: a lucky change would hide them.
void SteadyDry::claim(const DryCycle& cycle, const SteadyOptions& options, const Level& level,
                      const SteadyState& coarse, const Changes& before, SteadyState& out) const {
    constexpr double kHidden = 0.8, kBefore = 0.05;
    constexpr double kLuck = 0.15;  // a power seldom changes by less than this of a tolerance
    const Changes change = changes(out, coarse);
    const double time = span() / gait_.omega;
    const double unsure = kHidden * (level.moved + level.tolerance * slackness());
    const double by_state = unsure * follows(kDissipated, cycle) / time;
    out.speed_error =
        change.speed + kBefore * before.speed + unsure * cycle.scale()[0] / (robot_.n * robot_.m);
    out.turn_error = std::fabs(out.turn - coarse.turn) + kLuck * level.tolerance +
                     unsure * follows(kTurn, cycle);
    out.power_error =
        change.power + kBefore * before.power + kLuck * level.tolerance * out.power + by_state;
    if (options.powers) {  // what the joints' work and the friction's are apart
        out.power_error += std::fabs(net_work_ - end_.dissipated) / time;
        out.positive_power_error += by_state;
    }
    // derivatives jump where the sequence of modes does: one change says little of the next
    out.slowest_error = 5 * change.slowest + 0.3 * before.slowest;
    if (together_) out.slowest_error = std::max(out.slowest_error, std::fabs(out.slowest));
    claim_no_finer(options.rtol, out);
}

// What breaks off at one tolerance mostly does not at another: a level has some tries.
SteadyState SteadyDry::by_pieces(DryCycle& cycle, const SteadyOptions& options, double from) {
    SteadyState out = unknown(), coarse;
    constexpr double kLast = 1e-13;
    constexpr double kFirst = 0.12;  // so that the second level is mostly enough
    Changes before;
    Vec3 last_z = z_;
    std::vector<double> before_positive;
    bool first = true;
    int broken = 0;
    near_ = false;
    for (double tolerance = from * std::clamp(kFirst * options.rtol, 1e-7, 3e-4); tolerance > kLast;
         tolerance *= 0.05) {
        // the derivatives stand for the rest of the way; its square is what they miss
        const double goal = std::max((near_ ? 60 : 40) * tolerance, 1e-9);
        SteadyState next;
        next.iterations = out.iterations;
        const Ended ended = newton(cycle, tolerance, goal, options.powers, next);
        if (ended != Ended::converged) {
            if (++broken > 2) break;
            if (near_ || ended == Ended::broken) z_ = last_z;  // else it has come some of the way
            tolerance *= 10;                                   // half of this one comes next
            continue;
        }
        if (options.powers) add_positive(before_positive, next);
        near_ = true;
        Vec3 moved;
        for (int k = 0; k < 3; ++k) moved[k] = z_[k] - last_z[k];
        last_z = z_;
        claim(cycle, options, {tolerance, size(moved)}, coarse, before, next);
        next.converged = !first && excess(next, options) <= 1;
        if (first || excess(next, options) < excess(out, options)) out = next;
        if (out.converged) break;
        if (!first) before = changes(next, coarse);
        coarse = next, first = false;
    }
    return out;
}

// How much a quantity at the end changes with the state at the start, as a fraction of the scales.
double SteadyDry::follows(int row, const DryCycle& cycle) const {
    double sum = 0;
    for (int k = 0; k < 3; ++k) sum += std::fabs(end_.by_start[row][k]) * cycle.scale()[k];
    return sum;
}

// How many times the errors are what is asked for.
double SteadyDry::excess(const SteadyState& s, const SteadyOptions& options) const {
    const double floor = 1e-4 * gait_.omega * 2 * robot_.l * robot_.n;
    const double watts = 10 * std::max(s.power, s.positive_power) + 1e-300 / options.rtol;
    return std::max(s.speed_error / std::max(s.speed, floor),
                    std::max(s.power_error, s.positive_power_error) / watts) /
           options.rtol;
}

// A state to start from: by the parabola through the last three rates' ones, over the period, or
// the line through two, unless that is far out.
void SteadyDry::guess(double omega) {
    constexpr double kFar = 8;
    for (std::size_t count = known_.size(); count > 0; --count) {
        const Known* const from = known_.data() + known_.size() - count;
        Vec3 z{};
        double weights = 0;
        for (std::size_t k = 0; k < count; ++k) {
            double weight = 1;
            for (std::size_t j = 0; j < count; ++j)
                if (j != k)
                    weight *=
                        (1 / omega - 1 / from[j].omega) / (1 / from[k].omega - 1 / from[j].omega);
            weights += std::fabs(weight);
            for (int i = 0; i < 3; ++i) z[i] += weight * from[k].z[i];
        }
        if (weights > kFar) continue;
        z_ = z;
        return;
    }
}

// Keep what is known for the rates to come; after one that failed they begin anew.
void SteadyDry::remember(double omega, bool converged) {
    const auto same = [&](const Known& k) { return k.omega == omega; };
    if (!converged) known_.clear();
    std::erase_if(known_, same);
    if (known_.size() == 3) known_.erase(known_.begin());
    if (converged) known_.push_back({omega, z_});
}

// Joints that stand move nothing, and give no scales to count in: how disturbances die is that of
// the smallest waves, whose speed and power are nought.
SteadyState SteadyDry::at_rest(double omega, const SteadyOptions& options) const {
    Gait small = gait_;
    small.alpha = 1e-3;
    const SteadyState waving = SteadyDry(robot_, ground_, small).solve(omega, options);
    SteadyState rest;
    rest.monodromy = waving.monodromy, rest.slowest = waving.slowest;
    rest.slowest_error = waving.slowest_error;
    rest.iterations = waving.iterations, rest.converged = true;
    return rest;
}

SteadyState SteadyDry::solve(double omega, const SteadyOptions& options) {
    if (gait_.alpha == 0) return at_rest(omega, options);
    gait_.omega = omega;
    DryCycle cycle(robot_, ground_, gait_);
    cycle.limit(600'000 / robot_.n);
    SteadyState out = unknown();
    promising_ = promising_ && known_.size() > 1;
    if (!known_.empty()) {
        guess(omega);
        out = by_pieces(cycle, options, 1);
    }
    if (!out.converged) {  // from rest
        const Vec3 rest = {0, 0, cycle.momentum(0, 0) / cycle.scale()[2]};
        // Newton's method mostly needs no settled start; what breaks off at one sequence of
        // tolerances mostly does not at another. A state that repels is believed only of a motion
        // that has led there.
        struct Try {
            double from;
            int cycles;
        };
        constexpr Try kTries[] = {{1, 4}, {0.03, 4}, {1, 200}, {0.3, 4}, {0.1, 4}, {30, 4}};
        bool settled = false;
        for (const auto& [from, cycles] : kTries) {
            const double share = settled ? 1 : 0.5;
            if (!settled) z_ = rest;
            settled = settled || cycles > 4;
            if (!wander(cycle, cycles, 0.02, 1e-3 * from, share)) continue;
            SteadyState anew = by_pieces(cycle, options, from);
            if (!settled && anew.slowest > 0) anew.converged = false;
            if (anew.converged || excess(anew, options) < excess(out, options)) out = anew;
            if (anew.converged) break;
        }
    }
    remember(omega, out.converged);
    if (out.converged) return within_rounding(out);
    const SteadyState slow = steady_dry_by_steps(robot_, ground_, gait_, options);
    const bool slower = slow.converged || excess(slow, options) <= excess(out, options);
    return within_rounding(slower ? slow : out);
}

}  // namespace serpenoid
