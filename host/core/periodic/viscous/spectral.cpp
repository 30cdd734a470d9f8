// Starts, means and errors of spectral.hpp.
#include "periodic/viscous/spectral.hpp"

#include "body/joint_power.hpp"
#include "numerics/matrix_product.hpp"
#include "periodic/viscous/torque_series.hpp"

namespace serpenoid {

namespace {

// When Newton's steps end on a mesh, and what its error is stated as; held by the random states of
// tests/host/periodic/test_random_truth.py.
struct MeshErrors {
    int max_iterations = 15;
    double best_factor = 0.01;  // by which a change shrinks: a smaller one may be luck
    double first_factor = 0.1;  // the same of the first change
    double unsolved = 0.02;     // part of an error that Newton's steps may leave
    double rounded = 1e-11;     // no step is known better
    double resolved = 1e-4;     // else the first change of the next mesh tells nothing
    double rounding = 2e-15;    // of a speed, over half of body length times omega
    double turn = 1e-14;        // rad, least error
    double multiplier = 4e-3;   // largest error of its logarithm, relative
    double positive = 1e-6;     // largest error of positive power; pieces have no limit
    double squared = 3;         // of the coarse error's square, what the fine one may be
};
constexpr MeshErrors kMesh;

}  // namespace

// Newton's steps until the residual error is below `enough` in every gait. It is estimated as the
// last change times the factor by which changes shrink.
bool SpectralViscous::iterate(double enough, Batch& batch) {
    for (int i = 0; i < kMesh.max_iterations; ++i) {
        const Pack relative = newton_.step();
        bool done = true;
        for (int j = 0; j < kPack; ++j) {
            Solution& gait = batch[j];
            const double change = relative[j];
            if (!std::isfinite(change)) return false;
            if (i == 0) gait.first_change = change;
            const double shrinks = i == 0 ? kMesh.first_factor : change / (gait.change + 1e-300);
            gait.residual = change * std::clamp(shrinks, kMesh.best_factor, 1.0);
            gait.change = change;
            done = done && gait.residual <= enough;
        }
        if (done) return true;
    }
    return false;
}

// Means over the nodes.
void SpectralViscous::evaluate(bool powers, Batch& batch) {
    const SpectralMesh& mesh = SpectralMesh::level(level_);
    const std::vector<CycleNode>& nodes = nodes_[level_];
    const int N = mesh.nodes;
    Pack loss{}, fixed_loss{}, forward{}, sideways{}, heading{}, s, c;
    for (int k = 0; k < N; ++k) {
        const PackVec& u = newton_.y[k];
        loss += nodes[k].drag.dissipation(u, 1.0);
        fixed_loss += nodes[k].drag.dd;
        sincos(heading, s, c);
        forward += c * u[0] - s * u[1];
        sideways += s * u[0] + c * u[1];
        for (int j = 0; j < N; ++j) heading += mesh.row(k, j).integral[1] * newton_.y[j][2];
    }
    const Pack middle = 0.5 * heading;  // the path's direction: half way between both ends'
    sincos(middle, s, c);
    for (int j = 0; j < kPack; ++j) {
        Solution& gait = batch[j];
        const double w = omega_[j];
        gait.speed = w * (c[j] * forward[j] + s[j] * sideways[j]) / N;
        gait.heading = -middle[j];
        gait.power = w * w * loss[j] / N;
        gait.still_power = w * w * fixed_loss[j] / N;
        for (int i = 0; i < 9; ++i) gait.transfer[i] = newton_.transfer[i][j];
        gait.abs_power = gait.abs_error = 0;
    }
    if (powers) add_powers(batch);
}

// Means of every |P_i|.
void SpectralViscous::add_powers(Batch& batch) {
    const SpectralMesh& mesh = SpectralMesh::level(level_);
    const int N = mesh.nodes, joints = robot_.n - 1;
    std::vector<double> torque(kPack * joints * N);  // over omega^2
    const Pack g = 1.0 / omega_;
    for (int k = 0; k < N; ++k) {
        const CycleNode& node = nodes_[level_][k];
        const PackVec &u = newton_.y[k], rate = newton_.rate(k);
        const BodyMotionOf<Pack> motion{{u[0], u[1], u[2]}, {rate[0], rate[1], rate[2]}};
        joint_powers(
            robot_, node.shape, 1, motion,
            [&](int i) {
                const auto& link = node.shape.link[i];
                return std::pair(-g * ground_.along.c * link.t.speed(motion.u, 1),
                                 -g * ground_.across.c * link.n.speed(motion.u, 1));
            },
            [&](int i, Pack T, Pack) {
                for (int j = 0; j < kPack; ++j) torque[(j * joints + i) * N + k] = T[j];
            });
    }
    for (int j = 0; j < kPack; ++j) {
        const double cubed = omega_[j] * omega_[j] * omega_[j];
        for (int i = 0; i < joints; ++i) {
            TorqueSeries series(mesh, &torque[(j * joints + i) * N],
                                {alpha_ * table_.cosine(i), alpha_ * table_.sine(i)});
            batch[j].abs_power += cubed * series.mean_absolute();
            batch[j].abs_error += cubed * series.truncation_error();
        }
    }
}

// The state of one gait of a pack, with its errors.
SteadyState SpectralViscous::state_of(const SteadyOptions& options, const Solution& coarse,
                                      const Solution& fine, int lane) const {
    const double omega = omega_[lane];
    SteadyState state;
    state.speed = state.chord = std::fabs(fine.speed);
    state.direction = fine.speed < 0 ? std::numbers::pi - fine.heading : -fine.heading;
    state.power = fine.power;
    for (int c = 0; c < 3; ++c) state.start[c] = omega * newton_.y[0][c][lane];
    // by Cauchy and Schwarz: a relative change of the motion by `residual` changes power by no more
    // than this, with the power of the chain held still
    const double shrinks = std::clamp(kMesh.squared * fine.first_change, 1e-3, 1.0);
    const double speed_rest =
        fine.residual * state.speed + kMesh.rounding * omega * robot_.l * robot_.n;
    state.speed_error = stated_error(shrinks * std::fabs(fine.speed - coarse.speed) + speed_rest,
                                     options.rtol, state.speed);
    const double power_rest = 2 * fine.residual * std::sqrt(fine.still_power * state.power);
    const double power_change = shrinks * std::fabs(fine.power - coarse.power);
    state.power_error = stated_error(power_change + power_rest, options.rtol, state.power);
    state.turn_error = kMesh.turn;
    if (options.powers) {
        state.abs_power = fine.abs_power;
        state.positive_power = (fine.abs_power + fine.power) / 2;
        const double error =
            fine.abs_error + 2 * fine.residual * fine.still_power + power_change + power_rest;
        state.positive_power_error = stated_error(error / 2, options.rtol, state.positive_power);
    }
    // the transfer's order is four
    Mat3 half;
    double moved = 0;  // of the transfer: that of one number may be small by luck
    for (int i = 0; i < 9; ++i) {
        const double step = fine.transfer[i] - coarse.transfer[i];
        half[i] = fine.transfer[i] + step / 15;
        moved = std::max(moved, std::fabs(step));
    }
    const double large = largest(fine.transfer), J = nodes_[level_][0].shape.J[0];
    state.log_largest_multiplier = 2 * log_spectral_radius(half);
    const double error =
        std::fabs(state.log_largest_multiplier - 2 * log_spectral_radius(fine.transfer)) +
        fine.residual * std::fabs(state.log_largest_multiplier);
    for (int i = 0; i < 2; ++i) {
        half[3 * i + 2] /= J;
        half[6 + i] *= J;
    }
    state.monodromy = multiply(half, half);
    state.log_multiplier_error = 4 * error + (large > 0 ? moved / large / 4 : 0);
    state.converged =
        (options.rough || state.log_multiplier_error <=
                              kMesh.multiplier * std::fabs(state.log_largest_multiplier)) &&
        state.positive_power_error <=
            state.positive_power * std::max(options.rtol, kMesh.positive) &&
        Acceptance(options, robot_, ground_, omega)(state);
    return state;
}

void SpectralViscous::solve(const double* omega, int count, const SteadyOptions& options,
                            SteadyState* states) {
    for (int j = 0; j < kPack; ++j) {
        omega_[j] = omega[std::min(j, count - 1)];
        if (j < count) states[j] = {};
    }
    newton_.y = last_;  // at first from rest
    Batch batch{}, coarse{};
    for (level_ = 0; level_ < SpectralMesh::kLevels; ++level_) {
        const SpectralMesh& mesh = SpectralMesh::level(level_);
        std::vector<CycleNode>& nodes = nodes_[level_];
        if (nodes.empty()) nodes = cycle_nodes(robot_, ground_, table_, mesh);
        if (level_ > 0) newton_.refine();
        newton_.set(mesh, nodes, 1.0 / omega_);
        double smallest =
            1;  // a small power is known less well than the motion; 0/0 counts nothing
        for (const Solution& k : coarse) smallest = std::min(smallest, k.power / k.still_power);
        const double enough =
            kMesh.unsolved * std::clamp(smallest * options.rtol, kMesh.rounded, kMesh.resolved);
        if (!iterate(enough, batch)) return;
        if (level_ == 0) last_ = newton_.y;
        evaluate(options.powers && level_ > 0, batch);
        int accepted = 0;
        for (int j = 0; j < count && level_ > 0; ++j) {
            if (!states[j].converged) states[j] = state_of(options, coarse[j], batch[j], j);
            accepted += states[j].converged;
        }
        if (accepted == count) return;
        coarse = batch;
    }
}

}  // namespace serpenoid
