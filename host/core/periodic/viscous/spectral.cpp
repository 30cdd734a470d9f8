// Periodic states for SIMD batches of rates; the derivation stands in spectral.hpp.
#include "periodic/viscous/spectral.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "periodic/viscous/cycle_powers.hpp"

namespace serpenoid {

namespace {

constexpr int kMostNodes = SpectralMesh::kCoarsest << (SpectralMesh::kLevels - 1);

constexpr double kSlowest = 1e-3;  // most error of the multiplier's logarithm
// Multipliers that are nearly 1 are nearly equal: powers of the matrix tell their size no better.
constexpr double kLongMemory = 0.01, kPowers = 6e-7;
constexpr double kRounding = 2e-15;  // of a speed, over half of body length times omega

// Whether Hermite's rule shrinks what decays fast by more than `log_radius` in `steps` of z < 0: by
// Pade's approximant, (1 + z/2 + z^2/12) / (1 - z/2 + z^2/12), which is 1 again at infinity.
bool decays_faster(double z, int steps, double log_radius) {
    constexpr double kBest = -3.46, kMargin = 5;
    if (z > kBest) return true;
    const double even = 1 + z * z / 12, odd = z / 2;
    return steps * std::log((even + odd) / (even - odd)) < log_radius - kMargin;
}

double lane(const double* out, int what, int width, int k) { return out[what * width + k]; }

}  // namespace

SpectralViscous::SpectralViscous(const Robot& robot, const Ground& ground, const Gait& gait)
    : robot_(robot),
      ground_(ground),
      table_(robot.n, gait),
      alpha_(gait.alpha),
      y_(memory_.take(3 * kMostNodes * kWidth)),
      seed_y_(memory_.take(kSeeds * kCoarse)),
      g_(memory_.take(kWidth)),
      out_(memory_.take(kCycleOuts * kWidth)) {}

void SpectralViscous::tables(int k, bool powers) {
    Level& to = level_[k];
    if (to.node && (to.powers || !powers)) return;
    const SpectralMesh& mesh = SpectralMesh::level(k);
    const int n = robot_.n, N = mesh.nodes;
    to.node = memory_.take(kNodeFields * N);
    if (powers) to.joint = memory_.take(long{kJointFields} * N * (n - 1));
    if (N > work_nodes_) {
        work_nodes_ = std::max(N, 2 * SpectralMesh::kCoarsest);  // the second mesh needs it as well
        const int packs = CycleTask::kWork * work_nodes_;
        work_ = memory_.take(long{packs} * kWidth);
    }
    cycle_tables(robot_, ground_, table_, mesh.sine.data(), mesh.cosine.data(), N, to.node,
                 to.joint);
    to.powers = powers;
    if (powers) to.turns = turns(k);
    to.stiffest = 0;
    for (int i = 0; i < N; ++i)
        to.stiffest = std::max(
            to.stiffest, to.node[kBxx * N + i] + to.node[kByy * N + i] + to.node[kWw * N + i]);
    cycle_slopes(N, mesh.even_slope.data(), mesh.odd_slope.data(), to.node);
}

std::vector<JointTurn> SpectralViscous::turns(int k) const {
    const SpectralMesh& mesh = SpectralMesh::level(k);
    const int N = mesh.nodes;
    constexpr int wide = kLocal;
    std::vector<JointTurn> all;
    for (int i = 0; i + 1 < robot_.n; ++i) {
        const double from = table_.lag(i);  // the rate goes with cos(tau + lag)
        const double root = M_PI * (std::ceil(from / M_PI - 0.5) + 0.5) - from;
        JointTurn to{};
        to.place = std::clamp(root, 0.0, M_PI) / mesh.step;
        to.before = std::copysign(1.0, alpha_ * std::cos(from + root - M_PI / 2));
        const double* rate = &level_[k].joint[(long{kJointFields} * i + kRate) * N];
        to.swing = std::inner_product(rate, rate + N, rate, 0.0);
        const double a = to.place - std::min(static_cast<int>(to.place), N - 1);
        for (int j = 0; j < wide; ++j) {
            double integral = 0;
            for (int p = wide - 1; p >= 0; --p) {
                const double own = mesh.stencil[wide * p + j];
                to.value[j] = to.value[j] * a + own, integral = integral * a + own / (p + 1);
            }
            to.mend[j] = 2 * (mesh.stencil[wide * wide + j] - a * integral);
        }
        all.push_back(to);
    }
    return all;
}

CycleTask SpectralViscous::task(int k) const {
    const SpectralMesh& mesh = SpectralMesh::level(k);
    const Level& own = level_[k];
    return {mesh.nodes,
            robot_.n - 1,
            mesh.step,
            own.node,
            own.joint,
            own.turns.data(),
            mesh.rows.data(),
            mesh.folded.data(),
            mesh.modes.data(),
            mesh.stencil.data(),
            g_,
            y_,
            work_};
}

// Newton's steps until the residual error is below `enough` in every gait. It is estimated as the
// last change times the factor by which changes shrink; a mesh's first change is compared with the
// last one of the coarser mesh.
bool SpectralViscous::iterate(int k, double enough, bool first, Batch& found) {
    constexpr int kMost = 15;
    constexpr double kLeast = 0.01, kFirst = 0.1;
    CycleTask work = task(k);
    for (int i = 0; i < kMost; ++i) {
        cycle_newton(work, out_);
        bool done = true;
        for (int j = 0; j < kWidth; ++j) {
            const double size = lane(out_, kSize2, kWidth, j);
            const double change2 = lane(out_, kChange2, kWidth, j);
            if (!std::isfinite(change2)) return false;
            const double change = size > 0 ? std::sqrt(change2 / size) : 0;
            ++found[j].iterations;
            const double shrinks = change / found[j].change;
            found[j].residual_error =
                change * std::clamp(shrinks, kLeast, first && i == 0 ? kFirst : 1.0);
            found[j].change = change;
            if (found[j].residual_error > enough) done = false;
        }
        if (done) return true;
    }
    return false;
}

void SpectralViscous::evaluate(int k, bool powers, const double* omega, Batch& found) {
    CycleTask work = task(k);
    const int W = kWidth;
    double* out = out_;
    cycle_averages(work, out);
    if (powers) cycle_powers(work, out);
    const int N = SpectralMesh::level(k).nodes;
    const double* loss = &level_[k].node[kLoss * N];
    const double still = std::accumulate(loss, loss + N, 0.0) / N;
    for (int j = 0; j < W; ++j) {
        const auto at = [&](int what) { return lane(out, what, W, j); };
        const double w = omega[j], size = at(kSize2);
        Solution& to = found[j];
        to.speed = w * at(kAdvance);
        to.heading = at(kHeading);
        to.power = robot_.n * robot_.m * w * w * at(kDissipated);
        to.still_power = robot_.n * robot_.m * w * w * still;
        to.tail = size > 0 ? std::sqrt(at(kTail) / size) : 0;
        to.log_radius = 2 * M_LN2 * at(kLogRadius);
        to.abs_power = powers ? w * w * w * at(kMeanAbsPower) : 0;
        to.abs_error = powers ? w * w * w * at(kMeanAbsPowerError) : 0;
        for (int i = 0; i < 9; ++i) to.transfer[i] = at(kTransfer + i);
    }
}

// The state of one gait of a pack, with its errors.
SteadyState SpectralViscous::state_of(int k, const SteadyOptions& options, double omega,
                                      const Solution& coarse, const Solution& fine, int j) const {
    const int W = kWidth;
    SteadyState to;
    to.speed = to.chord = std::fabs(fine.speed);
    to.direction = fine.speed < 0 ? M_PI - fine.heading : -fine.heading;
    to.power = fine.power;
    to.elements = SpectralMesh::level(k).nodes, to.iterations = fine.iterations;
    to.start = {omega * y_[j], omega * y_[W + j], omega * y_[2 * W + j]};
    // by Cauchy and Schwarz: a relative change of the motion by `residual_error` changes power by
    // no more than this, with the power of the chain held still
    const double shrinks = coarse.tail > 0 ? std::clamp(fine.tail / coarse.tail, 1e-3, 1.0) : 1e-3;
    const ErrorRule rule{shrinks, 0, 0,
                         fine.residual_error * to.speed + kRounding * omega * robot_.l * robot_.n,
                         2 * fine.residual_error * std::sqrt(fine.still_power * to.power)};
    LevelChange change;
    change.speed = std::fabs(fine.speed - coarse.speed);
    change.power = std::fabs(fine.power - coarse.power);
    bound_errors(change, {}, rule, options.rtol, to);
    if (options.powers) {
        to.abs_power = fine.abs_power, to.positive_power = (fine.abs_power + fine.power) / 2;
        const double error = fine.abs_error + 2 * fine.residual_error * fine.still_power +
                             shrinks * change.power + rule.power;
        to.positive_power_error = least_bound(error / 2, options.rtol, to.positive_power);
    }
    return to;
}

// The monodromy matrix and its slowest multiplier. False where fast decay hides it.
bool SpectralViscous::multipliers(int k, double omega, const Solution& coarse, const Solution& fine,
                                  SteadyState& to) const {
    const int N = SpectralMesh::level(k).nodes;
    const double J = level_[k].node[kArm2 * N] * robot_.n * robot_.m;
    Mat3 half = {};
    for (int i = 0; i < 9; ++i) half[i] = fine.transfer[i];
    for (int i = 0; i < 2; ++i) half[3 * i + 2] /= J, half[6 + i] *= J;
    to.monodromy = multiply(half, half);
    const double change = fine.log_radius - coarse.log_radius;  // the transfer's order is four
    double moved = 0, large = 0;  // of the transfer: that of one number may be small by luck
    for (int i = 0; i < 9; ++i) {
        moved = std::max(moved, std::fabs(fine.transfer[i] - coarse.transfer[i]));
        large = std::max(large, std::fabs(fine.transfer[i]));
    }
    double error = std::fabs(change) / 15 + fine.residual_error * std::fabs(fine.log_radius);
    if (fine.log_radius > -kLongMemory) error += kPowers;
    to.slowest = fine.log_radius + change / 15;
    to.slowest_error = 4 * error + (large > 0 ? moved / large / 4 : 0);
    const double decay = -SpectralMesh::level(k).step * level_[k].stiffest / omega;
    return decays_faster(decay, 2 * N, to.slowest) && error <= kSlowest * std::fabs(to.slowest);
}

// Evaluate the level's solution. Iterate further where only the residual error is too large.
bool SpectralViscous::settle(int k, const double* omega, int count, const SteadyOptions& options,
                             const Batch& coarse, Batch& found, SteadyState* to) {
    constexpr int kMore = 4;
    for (int more = 0;; ++more) {
        evaluate(k, options.powers && k > 0, omega, found);
        if (k == 0) return false;
        bool all = true, more_helps = false;
        for (int j = 0; j < count; ++j) {
            if (to[j].converged) continue;
            const auto judge = [&](const Solution& fine) {
                SteadyState state = state_of(k, options, omega[j], coarse[j], fine, j);
                const bool known = multipliers(k, omega[j], coarse[j], fine, state);
                state.converged = (known || options.rough) &&
                                  Acceptance(options, robot_, ground_, omega[j])(state);
                return state;
            };
            to[j] = judge(found[j]);
            Solution exact = found[j];
            exact.residual_error = 0;
            more_helps = more_helps || (!to[j].converged && judge(exact).converged);
            all = all && to[j].converged;
        }
        if (all || !more_helps || more == kMore) return all;
        if (!iterate(k, HUGE_VAL, false, found)) return false;
    }
}

// Start from Lagrange's polynomial in log omega through the seeds; without seeds, from rest.
void SpectralViscous::guess(const double* omega) {
    const int W = kWidth, count = seed_count_;
    for (int j = 0; j < W && count > 0; ++j) {
        const double at = std::log(omega[j]);
        for (int i = 0; i < count; ++i) {
            double weight = seeds_[i].weight;
            for (int k = 0; k < count; ++k)
                if (k != i) weight *= at - seeds_[k].log_omega;
            work_[i * W + j] = weight;
        }
    }
    cycle_blend(count, kCoarse, work_, seed_y_, y_);
}

// Keep solutions as seeds, with the part of Lagrange's weights that all rates share.
void SpectralViscous::remember(const double* omega, int count) {
    constexpr double kApart = 0.01;  // a seed next to another adds little
    for (int j = 0; j < count && seed_count_ < kSeeds; ++j) {
        Seed next{std::log(omega[j]), 1};
        const auto end = seeds_.begin() + seed_count_;
        if (std::any_of(seeds_.begin(), end, [&](const Seed& other) {
                return std::fabs(other.log_omega - next.log_omega) < kApart;
            }))
            continue;
        for (auto other = seeds_.begin(); other != end; ++other) {
            other->weight /= other->log_omega - next.log_omega;
            next.weight /= next.log_omega - other->log_omega;
        }
        double* to = seed_y_ + kCoarse * seed_count_;
        for (int i = 0; i < kCoarse; ++i) to[i] = y_[i * kWidth + j];
        seeds_[seed_count_++] = next;
    }
}

void SpectralViscous::solve(const double* omega, int count, const SteadyOptions& options,
                            SteadyState* to) {
    const int W = kWidth;
    std::array<double, kWidth> rates;
    for (int j = 0; j < W; ++j) {
        rates[j] = omega[std::min(j, count - 1)];
        g_[j] = 1 / rates[j];
        if (j < count) to[j] = {};
    }
    Batch found{}, coarse;
    for (Solution& f : found) f.change = 1;
    for (int k = 0; k < SpectralMesh::kLevels; ++k) {
        if (k > 0) {
            const SpectralMesh& mesh = SpectralMesh::level(k - 1);
            cycle_refine(mesh.nodes, mesh.even_half.data(), mesh.odd_half.data(), y_, work_);
        }
        tables(k, options.powers && k > 0);
        if (k == 0) guess(rates.data());
        const double enough = k == 0 ? 10 * std::clamp(options.rtol, 1e-11, 1e-6)
                                     : 0.02 * std::clamp(options.rtol, 1e-11, 1e-4);
        if (!iterate(k, enough, true, found)) return;
        if (k == 0) remember(rates.data(), count);
        const bool all = settle(k, rates.data(), count, options, coarse, found, to);
        if (all) return;
        coarse = found;
    }
}

}  // namespace serpenoid
