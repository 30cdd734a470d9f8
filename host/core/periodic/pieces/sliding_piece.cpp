// Newton's method on the stages of sliding_piece.hpp; states, forces and errors of its polynomial.
#include "periodic/pieces/sliding_piece.hpp"

#include <algorithm>
#include <cmath>

namespace serpenoid {

namespace {

// Newton's method on a piece; its steps are fractions of the scales.
struct NewtonTuning {
    double curvature_safety = 10;  // factor on the curvature that the last two steps show
    double quadratic_step = 0.1;   // step below which each step is the last one squared
    double diverged_step = 1e12;   // step that counts as divergence
    int max_iterations = 12;       // limit; mostly two or three do: almost linear equations
};
constexpr NewtonTuning kNewton;

// Parts of the error of a piece; held by random states of other code
// (tests/host/periodic/test_random_truth.py).
struct ErrorTuning {
    // Weight of a small error of a force. A large one weighs as its square, times the ratio of
    // that force to inertia: it shifts the end of sticking, and only this shifts the motion.
    double force_weight = 0.02;
    double drift_weight = 0.3;     // mean drift over the drift at between_stages
    double rate_weight = 0.0299;   // maximum of the integral of prod (1 - x/c_k)
    double between_stages = 0.73;  // fraction of a piece farthest from its stages
};
constexpr ErrorTuning kError;

double dot(const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

Vec3 cross(const Vec3& a, const Vec3& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

// Solve G x = b for the Gram matrix G of up to three weighted rows; x holds b, then the solution,
// or zero if G is singular.
void solve_gram(const Vec3* rows, int count, const Vec3& weight, Vec3& x) {
    if (count == 0) return;
    Mat3 G = identity3();
    for (int a = 0; a < count; ++a)
        for (int b = 0; b < count; ++b) {
            double& sum = G[3 * a + b] = 0;
            for (int i = 0; i < 3; ++i) sum += rows[a][i] * rows[b][i] * weight[i];
        }
    if (!solve_dense<3, 1>(G.data(), x.data())) x = {};
}

// Coefficients x that minimise |Q + sum_a x_a g_a|, for up to three rows g.
Vec3 least_squares(const Vec3* g, int count, const Vec3& Q) {
    Vec3 x{};
    for (int a = 0; a < count; ++a) x[a] = -dot(g[a], Q);
    solve_gram(g, count, {1, 1, 1}, x);
    return x;
}

}  // namespace

SlidingPiece::SlidingPiece(const Robot& robot, const Ground& ground, const Gait& gait)
    : robot_(robot),
      omega_(gait.omega),
      nm_(robot.n * robot.m),
      inverse_nm_(1 / nm_),
      law_{ground.along, ground.across},
      breakaway_ratio_(law_[0].breakaway_ratio(nm_ * gait.omega * gait.omega * robot.l *
                                               std::max(gait.alpha, 1e-9))),
      table_(robot.n, gait),
      stages_(robot, gait),
      viscous_(2 * robot.n),
      dry_(2 * robot.n),
      force_(2 * robot.n) {}

void SlidingPiece::set_shapes(int lanes, const Lanes& tau) {
    stages_.set(lanes, tau);
    for (int j = 0; j < lanes; ++j) {
        node_[j].J = stages_.J(j);
        node_[j].K = stages_.K(j);
        node_[j].inverse_J = 1 / node_[j].J;
    }
}

void SlidingPiece::sum_wheels(int lanes, const std::vector<double>& direction) {
    for (int c = 0; c < 2 * robot_.n; ++c) viscous_[c] = law(c).viscous(direction[c]);
    for (int j = 0; j < lanes; j += kPack)
        stages_.sums(j / kPack, viscous_.data(), dry_.data(), {&node_[j], &node_[j + 1]});
}

void SlidingPiece::set_nodes(double tau0, double tau1) { set_shapes(2, {{tau0, tau1}}); }

void SlidingPiece::sum_nodes(const std::vector<double>& direction) {
    for (int c = 0; c < 2 * robot_.n; ++c) dry_[c] = -law(c).thrust();
    sum_wheels(2, direction);
}

Vec3 SlidingPiece::direction(int wheel, int j) const {
    const WheelDirection g = row(wheel, j);
    return {g.x, g.y, g.r};
}

// dp/dtau without the stuck wheels' forces.
Vec3 SlidingPiece::free_rate(const Node& node, const Vec3& p, const Vec3& u) const {
    const double inverse_omega = 1 / omega_;
    const Vec3 drag = node.drag(u, omega_), &dry = node.dry;
    return {inverse_omega * (u[2] * p[1] - dry[0] - drag[0]),
            inverse_omega * (-u[2] * p[0] - dry[1] - drag[1]), inverse_omega * (-dry[2] - drag[2])};
}

// The derivative of free_rate by p; Vx, Vy and w enter it by their own derivatives by p.
Mat3 SlidingPiece::free_jacobian(const Node& node, const Vec3& p, const Vec3& u) const {
    const double inverse_omega = 1 / omega_, V_by_p = inverse_omega * inverse_nm_;
    const double w_by_p = inverse_omega * node.inverse_J, turn = inverse_omega * u[2];
    const double* D = node.D;
    // clang-format off
    return {-D[0] * V_by_p,        -D[1] * V_by_p + turn, (-D[2] + p[1]) * w_by_p,
            -D[1] * V_by_p - turn, -D[3] * V_by_p,        (-D[4] - p[0]) * w_by_p,
            -D[2] * V_by_p,        -D[4] * V_by_p,        -D[5] * w_by_p};
    // clang-format on
}

// Three directions at a node: first those in which no stuck wheel pushes, then the rows of the
// stuck wheels.
std::array<Vec3, 3> SlidingPiece::equation_directions(int j) const {
    const int constraints = mode_->count;
    std::array<Vec3, 3> d{Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};
    for (int a = 0; a < constraints; ++a) d[3 - constraints + a] = direction(mode_->stuck[a], j);
    if (constraints == 2) d[0] = cross(d[1], d[2]);
    if (constraints == 1) {  // a row has a unit vector in its first two components
        const Vec3 g = d[2];
        d[0] = {-g[1], g[0], 0};
        d[1] = {-g[2] * g[0], -g[2] * g[1], 1};
    }
    return d;
}

// h times the rate of the polynomial at stage j.
Vec3 SlidingPiece::stage_rate(int j) const {
    const auto& D = Rule::get().rate;
    Vec3 r{};
    for (int k = 0; k < s; ++k)
        for (int i = 0; i < 3; ++i) r[i] += D[j * s + k] * (Y_[k][i] - p0_[i]);
    return r;
}

// One step of Newton's method on Y_, and its derivative T_ by p0; false if the matrix is singular.
bool SlidingPiece::newton_step() {
    const auto& D = Rule::get().rate;
    const int constraints = mode_->count;
    std::array<double, N * N> matrix{};
    std::array<double, N * 4> solution;  // columns: the step, and the derivatives by p0
    for (int j = 0; j < s; ++j) {
        const Node& node = node_[j + 1];
        const auto d = equation_directions(j + 1);
        const Vec3 u = velocity(node, Y_[j]), F = free_rate(node, Y_[j], u);
        const Mat3 A = free_jacobian(node, Y_[j], u);
        Vec3 Q = stage_rate(j);
        for (int i = 0; i < 3; ++i) Q[i] -= h_ * F[i];
        for (int r = 0; r < 3; ++r) {
            const int equation = 3 * j + r;
            double *line = &matrix[equation * N], *right = &solution[equation * 4];
            Vec3 slope;  // derivative by this stage without that of the polynomial's rate
            if (r < 3 - constraints) {
                for (int m = 0; m < s; ++m)
                    for (int i = 0; i < 3; ++i) line[3 * m + i] = D[j * s + m] * d[r][i];
                for (int i = 0; i < 3; ++i)
                    slope[i] = -h_ * (d[r][0] * A[i] + d[r][1] * A[3 + i] + d[r][2] * A[6 + i]);
                right[0] = -dot(d[r], Q);
            } else {
                const WheelDirection g = row(mode_->stuck[r - 3 + constraints], j + 1);
                slope = {g.x * inverse_nm_, g.y * inverse_nm_, g.r * node.inverse_J};
                right[0] = -g.speed(u.data(), omega_);
            }
            for (int i = 0; i < 3; ++i) line[3 * j + i] += slope[i];
            for (int i = 0; i < 3; ++i) right[1 + i] = -slope[i];
        }
    }
    if (!solve_dense<N, 4>(matrix.data(), solution.data())) return false;
    change_ = {};
    for (int j = 0; j < s; ++j)
        for (int i = 0; i < 3; ++i) {
            const double* row = &solution[(3 * j + i) * 4];
            Y_[j][i] += row[0];
            change_[i] = std::max(change_[i], std::fabs(row[0]));
            for (int c = 0; c < 3; ++c) T_[j][3 * i + c] = (i == c) + row[1 + c];
        }
    return true;
}

bool SlidingPiece::solve(const SlidingMode& mode, double tau, double h, const Vec3& p0,
                         const Vec3& scale, double tolerance) {
    const Rule& rule = Rule::get();
    mode_ = &mode;
    tau_ = tau;
    h_ = h;
    p0_ = p0;
    Lanes phase{{tau}};
    for (int j = 0; j < s; ++j) phase.value[j + 1] = tau + h * rule.c[j];
    phase.value[s + 1] = tau + h * kError.between_stages;
    set_shapes(s + 2, phase);
    for (int c = 0; c < 2 * robot_.n; ++c)
        dry_[c] = law(c).bound() * mode.sign[c] - law(c).thrust();
    sum_wheels(s + 1, mode.sign);
    Y_.fill(p0);
    double step = HUGE_VAL;
    for (int i = 0; i < kNewton.max_iterations; ++i) {
        const double last_step = step;
        if (!newton_step()) return false;
        step = std::max({change_[0] / scale[0], change_[1] / scale[1], change_[2] / scale[2]});
        if (!(step < kNewton.diverged_step)) return false;
        // The next step would be this one squared, times the curvature. The first step alone does
        // not show the curvature.
        const double curvature =
            std::min(kNewton.curvature_safety * step / (last_step * last_step), 1.0);
        if (i > 0 && step < kNewton.quadratic_step && curvature * step * step < tolerance) {
            u_[0] = velocity(node_[0], p0_);
            for (int j = 0; j < s; ++j) u_[j + 1] = velocity(node_[j + 1], Y_[j]);
            set_stuck_forces();
            return true;
        }
    }
    return false;
}

void SlidingPiece::speeds(Lanes* wheel_speeds) const {
    Lanes u[3]{};
    for (int j = 0; j <= s; ++j)
        for (int i = 0; i < 3; ++i) u[i].value[j] = u_[j][i];
    stages_.speeds(s + 1, u, wheel_speeds);
}

double SlidingPiece::speed(int wheel, double x) {
    const double tau = tau_ + h_ * x;
    scratch_shape_.set(robot_, table_, std::sin(tau), std::cos(tau), false);
    const LinkShape& link = scratch_shape_.link[wheel / 2];
    const Vec3 p = momenta(x), u{p[0] * inverse_nm_, p[1] * inverse_nm_,
                                 (p[2] - omega_ * scratch_shape_.K) / scratch_shape_.J};
    return (wheel % 2 ? link.n : link.t).speed(u.data(), omega_);
}

void SlidingPiece::lower_bounds(const Lanes* values, double* bounds) const {
    static const auto weights = [] {
        std::array<Lanes, s + 1> bernstein_of_unit{};
        for (int j = 0; j <= s; ++j) {
            double unit[s + 1]{};
            unit[j] = 1;
            const auto b = StagePolynomial<s>(unit).bernstein();
            for (int i = 0; i < Lanes::kCount; ++i)
                bernstein_of_unit[j].value[i] = b[std::min(i, s)];
        }
        return bernstein_of_unit;
    }();
    for (int wheel = 0; wheel < wheels(); ++wheel) {
        std::array<double, Lanes::kCount> sum{};
        for (int j = 0; j <= s; ++j)
            for (int i = 0; i < Lanes::kCount; ++i)
                sum[i] += weights[j].value[i] * values[wheel].value[j];
        bounds[wheel] = *std::min_element(sum.begin(), sum.end());
    }
}

void SlidingPiece::set_stuck_forces() {
    const SlidingMode& mode = *mode_;
    if (mode.count == 0) return;
    for (int j = 0; j < s; ++j) {
        Vec3 Q = stage_rate(j), g[3]{};
        const Vec3 F = free_rate(node_[j + 1], Y_[j], u_[j + 1]);
        for (int i = 0; i < 3; ++i) Q[i] = omega_ * (Q[i] / h_ - F[i]);
        for (int a = 0; a < mode.count; ++a) g[a] = direction(mode.stuck[a], j + 1);
        lambda_[j] = least_squares(g, mode.count, Q);
    }
}

Vec3 SlidingPiece::correction(int node, const SlidingMode& mode, const Vec3& u) const {
    Vec3 impulse{}, change{}, g[3]{};
    for (int a = 0; a < mode.count; ++a) {
        g[a] = direction(mode.stuck[a], node);
        impulse[a] = -row(mode.stuck[a], node).speed(u.data(), omega_);
    }
    solve_gram(g, mode.count, {inverse_nm_, inverse_nm_, node_[node].inverse_J}, impulse);
    for (int a = 0; a < mode.count; ++a)
        for (int i = 0; i < 3; ++i) change[i] += impulse[a] * g[a][i];
    return change;
}

// The largest of three errors. (1) The rate of the polynomial at the start, less the part that
// forces of stuck wheels balance: a rate wrong by delta makes the polynomial wrong by up to
// rate_weight h delta. (2) Those forces, compared with the ones extrapolated from the stages. (3)
// The motion of stuck wheels between the stages, which the rate does not show.
double SlidingPiece::error(const Vec3& scale) {
    const Vec3 F = free_rate(node_[0], p0_, u_[0]), slope = rate(0);
    Vec3 Q, g[3]{};
    for (int i = 0; i < 3; ++i) Q[i] = (slope[i] - F[i]) / scale[i];
    for (int a = 0; a < mode_->count; ++a) {
        g[a] = direction(mode_->stuck[a], 0);
        for (int i = 0; i < 3; ++i) g[a][i] /= scale[i];
    }
    const Vec3 x = least_squares(g, mode_->count, Q);
    const Vec3 drift =
        mode_->count == 0
            ? Vec3{}
            : correction(s + 1, *mode_, velocity(node_[s + 1], momenta(kError.between_stages)));
    double rate_error = 0, force_error = 0, force_ratio = 0, max_drift = 0;
    for (int a = 0; a < mode_->count; ++a) {
        const double bound = law(mode_->stuck[a]).bound() / breakaway_ratio(mode_->stuck[a]);
        force_error = std::max(force_error, std::fabs(omega_ * x[a] - stuck_force(a, 0)) / bound);
        force_ratio = std::max(force_ratio, bound / (2 * omega_ * scale[0]));
    }
    for (int i = 0; i < 3; ++i) {
        for (int a = 0; a < mode_->count; ++a) Q[i] += x[a] * g[a][i];
        rate_error = std::max(rate_error, std::fabs(Q[i]));
        max_drift = std::max(max_drift, std::fabs(drift[i]) / scale[i]);
    }
    drift_ = max_drift * scale[0] * inverse_nm_;
    const double force_weight = std::max(kError.force_weight, force_ratio * force_error);
    return std::max({h_ * rate_error * kError.rate_weight, force_weight * force_error,
                     kError.drift_weight * max_drift});
}

Vec3 SlidingPiece::momenta(double x) const {
    if (x == 0) return p0_;
    const auto w = Rule::get().dense(x);
    Vec3 p = p0_;
    for (int k = 0; k < s; ++k)
        for (int i = 0; i < 3; ++i) p[i] += w[k] * (Y_[k][i] - p0_[i]);
    return p;
}

Vec3 SlidingPiece::rate(double x) const {
    const auto& D = Rule::get().rate;
    const auto w = Rule::get().weights(x);
    Vec3 r{};
    for (int k = 0; k < s; ++k) {
        double weight = 0;
        for (int j = 0; j < s; ++j) weight += w[j] * D[j * s + k] / h_;
        for (int i = 0; i < 3; ++i) r[i] += weight * (Y_[k][i] - p0_[i]);
    }
    return r;
}

Mat3 SlidingPiece::tangent(double x) const {
    const auto w = Rule::get().dense(x);
    Mat3 T = identity3();
    for (int k = 0; k < s; ++k)
        for (int i = 0; i < 9; ++i) T[i] += w[k] * (T_[k][i] - (i % 4 == 0));
    return T;
}

double SlidingPiece::stuck_force(int a, double x) const {
    const auto w = Rule::get().weights(x);
    double sum = 0;
    for (int j = 0; j < s; ++j) sum += w[j] * lambda_[j][a];
    return sum;
}

void SlidingPiece::torques(int count, const double* x, Lanes* torque, Lanes* rate) {
    Lanes tau{}, lanes[3]{};
    for (int c = 0; c < 2 * robot_.n; ++c) std::fill_n(force_[c].value, count, dry_[c]);
    for (int q = 0; q < count; ++q) {
        tau.value[q] = tau_ + h_ * x[q];
        for (int a = 0; a < mode_->count; ++a)
            force_[mode_->stuck[a]].value[q] += stuck_force(a, x[q]);
        const Vec3 p = momenta(x[q]);
        for (int i = 0; i < 3; ++i) lanes[i].value[q] = p[i];
    }
    stages_.torques(count, tau, lanes, viscous_.data(), force_.data(), torque, rate);
}

}  // namespace serpenoid
