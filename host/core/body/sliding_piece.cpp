// Newton's method on the stages of sliding_piece.hpp, and what its polynomial tells.
#include "body/sliding_piece.hpp"

#include <algorithm>
#include <cmath>

namespace serpenoid {

namespace {

constexpr int s = SlidingPiece::kStages;

// Rate of the polynomial at stage j, times h: sum_k of this times (Y_k - p0). Inverse of a.
const std::array<double, s * s>& differentiation() {
    static const std::array<double, s * s> D = [] {
        auto A = SlidingPiece::Rule::get().a;
        std::array<double, s * s> I{};
        for (int k = 0; k < s; ++k) I[k * s + k] = 1;
        solve_dense<s, s>(A.data(), I.data());
        return I;
    }();
    return D;
}

double dot(const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

Vec3 cross(const Vec3& a, const Vec3& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

// x of least |Q + sum_a x_a g_a| for up to three rows g.
Vec3 least_squares(const Vec3* g, int count, const Vec3& Q) {
    Vec3 x{};
    if (count == 1) x[0] = -dot(g[0], Q) / dot(g[0], g[0]);
    if (count == 2) {
        double S[4] = {dot(g[0], g[0]), dot(g[0], g[1]), dot(g[1], g[0]), dot(g[1], g[1])};
        double b[2] = {-dot(g[0], Q), -dot(g[1], Q)};
        if (solve_dense<2, 1>(S, b)) x = {b[0], b[1], 0};
    }
    if (count == 3) {
        Mat3 S;
        for (int i = 0; i < 3; ++i)
            for (int a = 0; a < 3; ++a) S[3 * i + a] = g[a][i];
        Vec3 b = {-Q[0], -Q[1], -Q[2]};
        if (solve_dense<3, 1>(S.data(), b.data())) x = b;
    }
    return x;
}

Vec3 direction(const WheelDirection& row) { return {row.x, row.y, row.r}; }

}  // namespace

SlidingPiece::SlidingPiece(const Robot& robot, const Ground& ground, const Gait& gait, Solve solve)
    : robot_(robot),
      ground_(ground),
      omega_(gait.omega),
      nm_(robot.n * robot.m),
      ft0_(ground.ft0_mean()),
      thrust_(ground.thrust()),
      grip_(ground.grip(nm_ * gait.omega * gait.omega * robot.l * std::max(gait.alpha, 1e-9))),
      table_(robot.n, gait),
      solve_(solve) {
    for (Node& k : node_) k.row.resize(2 * robot.n);
}

void SlidingPiece::fill(Node& k, double tau) {
    shape_.set(robot_, table_, std::sin(tau), std::cos(tau), false);
    k.J = shape_.J, k.K = shape_.K;
    static_cast<ViscousSums&>(k) = ViscousSums(shape_, ground_);
    for (int i = 0; i < robot_.n; ++i)
        k.row[2 * i] = shape_.link[i].t, k.row[2 * i + 1] = shape_.link[i].n;
}

void SlidingPiece::drag(Node& k, const std::vector<double>& way) const {
    if (ground_.ct == ground_.ct_back) return;
    static_cast<ViscousSums&>(k) = {};
    for (int c = 0; c < 2 * robot_.n; ++c) k.add(k.row[c], viscous(c, way[c]));
}

void SlidingPiece::sum_mode(Node& k, const SlidingMode& mode) const {
    drag(k, mode.sign);
    k.dry = {}, k.dry_e = 0;
    for (int c = 0; c < 2 * robot_.n; ++c) {
        const double f = mu(c) * mode.sign[c] - thrust(c);
        const WheelDirection& g = k.row[c];
        k.dry[0] += f * g.x, k.dry[1] += f * g.y, k.dry[2] += f * g.r, k.dry_e += f * g.e;
    }
}

Vec3 SlidingPiece::velocity(const Node& k, const Vec3& p) const {
    return {p[0] / nm_, p[1] / nm_, (p[2] - omega_ * k.K) / k.J};
}

// dp/dtau without the stuck wheels' forces.
Vec3 SlidingPiece::free_rate(const Node& k, const Vec3& p) const {
    const Vec3 u = velocity(k, p);
    const double io = 1 / omega_, w = u[2], *D = k.D;
    return {io * (w * p[1] - k.dry[0] - D[0] * u[0] - D[1] * u[1] - D[2] * w) - k.d[0],
            io * (-w * p[0] - k.dry[1] - D[1] * u[0] - D[3] * u[1] - D[4] * w) - k.d[1],
            io * (-k.dry[2] - D[2] * u[0] - D[4] * u[1] - D[5] * w) - k.d[2]};
}

Mat3 SlidingPiece::free_jacobian(const Node& k, const Vec3& p) const {
    const double io = 1 / omega_, im = io / nm_, iJ = io / k.J, *D = k.D;
    const double w = io * (p[2] - omega_ * k.K) / k.J;
    return {-D[0] * im,          -D[1] * im + w, (-D[2] + p[1]) * iJ, -D[1] * im - w, -D[3] * im,
            (-D[4] - p[0]) * iJ, -D[2] * im,     -D[4] * im,          -D[5] * iJ};
}

// Three directions: first those in which no stuck wheel pushes, then the stuck wheels' rows.
std::array<Vec3, 3> SlidingPiece::split(const Node& k, int& constraints) const {
    constraints = mode_->count;
    std::array<Vec3, 3> d{Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};
    for (int a = 0; a < constraints; ++a)
        d[3 - constraints + a] = direction(k.row[mode_->stuck[a]]);
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
    const auto& D = differentiation();
    Vec3 r{};
    for (int k = 0; k < s; ++k)
        for (int i = 0; i < 3; ++i) r[i] += D[j * s + k] * (Y_[k][i] - p0_[i]);
    return r;
}

// One step of Newton's method, and the derivative by p0.
bool SlidingPiece::step() {
    const auto& diff = differentiation();
    for (int j = 0; j < s; ++j) {
        const Node& k = node_[j + 1];
        int constraints;
        const auto d = split(k, constraints);
        const Vec3 F = free_rate(k, Y_[j]), u = velocity(k, Y_[j]);
        const Mat3 A = free_jacobian(k, Y_[j]);
        Vec3 Q = stage_rate(j);
        for (int i = 0; i < 3; ++i) Q[i] -= h_ * F[i];
        for (int r = 0; r < 3; ++r) {
            double* row = &rows_[(3 * j + r) * kRow];
            double* right = row + kRight;
            std::fill_n(row, kRight, 0.0);
            Vec3 own;  // derivative by this stage beyond the polynomial's rate
            if (r < 3 - constraints) {
                for (int m = 0; m < s; ++m)
                    for (int i = 0; i < 3; ++i) row[3 * m + i] = diff[j * s + m] * d[r][i];
                for (int i = 0; i < 3; ++i)
                    own[i] = -h_ * (d[r][0] * A[i] + d[r][1] * A[3 + i] + d[r][2] * A[6 + i]);
                right[0] = -dot(d[r], Q);
            } else {
                const WheelDirection& g = k.row[mode_->stuck[r - 3 + constraints]];
                own = {g.x / nm_, g.y / nm_, g.r / k.J};
                right[0] = -g.speed(u.data(), omega_);
            }
            for (int i = 0; i < 3; ++i) row[3 * j + i] += own[i];
            for (int i = 0; i < 3; ++i) right[1 + i] = -own[i];
        }
    }
    if (!solve_(rows_.data())) return false;
    change_[0] = change_[1] = change_[2] = 0;
    for (int j = 0; j < s; ++j)
        for (int i = 0; i < 3; ++i) {
            const double* r = &rows_[(3 * j + i) * kRow + kRight];
            Y_[j][i] += r[0];
            change_[i] = std::max(change_[i], std::fabs(r[0]));
            for (int c = 0; c < 3; ++c) T_[j][3 * i + c] = (i == c) + r[1 + c];
        }
    return true;
}

bool SlidingPiece::solve(const SlidingMode& mode, double tau, double h, const Vec3& p0,
                         const Vec3& scale, double close) {
    const Rule& rule = Rule::get();
    mode_ = &mode, h_ = h, p0_ = p0;
    for (int j = 0; j < s; ++j) {
        fill(node_[j + 1], tau + h * rule.c[j]);
        sum_mode(node_[j + 1], mode);
        Y_[j] = p0;
    }
    sum_mode(node_[0], mode);
    double size = HUGE_VAL;
    for (int i = 0; i < 12; ++i) {
        const bool near = i > 0;  // the equations are almost linear: one step comes close
        if (!step()) return false;
        size = std::max({change_[0] / scale[0], change_[1] / scale[1], change_[2] / scale[2]});
        if (!(size < 1e12)) return false;
        if (near && size < 0.1 && size * size < close) {
            stuck_forces(mode);
            return true;
        }
    }
    return false;
}

void SlidingPiece::stuck_forces(const SlidingMode& mode) {
    if (mode.count == 0) return;
    for (int j = 0; j < s; ++j) {
        Vec3 Q = stage_rate(j), g[3];
        const Vec3 F = free_rate(node_[j + 1], Y_[j]);
        for (int i = 0; i < 3; ++i) Q[i] = omega_ * (Q[i] / h_ - F[i]);
        for (int a = 0; a < mode.count; ++a) g[a] = direction(node_[j + 1].row[mode.stuck[a]]);
        lambda_[j] = least_squares(g, mode.count, Q);
    }
}

// What the polynomial's rate at the start is off by, but for what a stuck wheel's force takes up;
// and how far that force is from the one that the stages tell.
double SlidingPiece::error(const Vec3& scale) const {
    constexpr double kForce = 0.02;  // an end of sticking shifts the motion by the square of it
    const Rule& rule = Rule::get();
    const Vec3 F = free_rate(node_[0], p0_), slope = rate(0);
    Vec3 Q, g[3]{};
    for (int i = 0; i < 3; ++i) Q[i] = (slope[i] - F[i]) / scale[i];
    for (int a = 0; a < mode_->count; ++a) {
        g[a] = direction(node_[0].row[mode_->stuck[a]]);
        for (int i = 0; i < 3; ++i) g[a][i] /= scale[i];
    }
    const Vec3 x = least_squares(g, mode_->count, Q);
    double most = 0, force = 0;
    for (int a = 0; a < mode_->count; ++a)
        force =
            std::max(force, grip(mode_->stuck[a]) * std::fabs(omega_ * x[a] - stuck_force(a, 0)) /
                                mu(mode_->stuck[a]));
    for (int i = 0; i < 3; ++i) {
        for (int a = 0; a < mode_->count; ++a) Q[i] += x[a] * g[a][i];
        most = std::max(most, std::fabs(Q[i]));
    }
    return std::max(h_ * most * rule.bump_height, kForce * force);
}

Vec3 SlidingPiece::at(double x) const {
    if (x == 0) return p0_;
    const auto w = Rule::get().dense(x);
    Vec3 p = p0_;
    for (int k = 0; k < s; ++k)
        for (int i = 0; i < 3; ++i) p[i] += w[k] * (Y_[k][i] - p0_[i]);
    return p;
}

// The rates at the stages, interpolated.
Vec3 SlidingPiece::rate(double x) const {
    const Rule& rule = Rule::get();
    Vec3 r{};
    for (int j = 0; j < s; ++j) {
        const double w = rule.dense(x)[j] * rule.c[j] / (x > 0 ? x : 1);
        const Vec3 v = stage_rate(j);
        const double at = x > 0 ? w : rule.at0[j];
        for (int i = 0; i < 3; ++i) r[i] += at * v[i] / h_;
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
    const Rule& rule = Rule::get();
    const auto w = rule.dense(x);
    double sum = 0;
    for (int j = 0; j < s; ++j)
        sum += (x != 0 ? w[j] * rule.c[j] / x : rule.at0[j]) * lambda_[j][a];
    return sum;
}

}  // namespace serpenoid
