// The tables and the iteration of viscous_piece.hpp.
#include "body/viscous_piece.hpp"

#include <algorithm>
#include <cmath>

#include "body/viscous_drag.hpp"

namespace serpenoid {

namespace {

// A and b of viscous_piece.hpp at one phase.
void linear_part(const BodyShape& shape, const Robot& robot, const Ground& ground, double omega,
                 Mat3& A, Vec3& b) {
    const ViscousSums f(shape, ground);
    const double io = 1 / omega, inm = io / (robot.n * robot.m), iJ = 1 / shape.J;
    const double turn = shape.K * iJ;  // the known part of w is -omega turn
    const double (&D)[6] = f.D;
    A = {-D[0] * inm,      -D[1] * inm - turn, -D[2] * inm * iJ, -D[1] * inm + turn, -D[3] * inm,
         -D[4] * inm * iJ, -D[2] * io,         -D[4] * io,       -D[5] * io * iJ};
    b = {omega * inm * (D[2] * turn - f.d[0]), omega * inm * (D[4] * turn - f.d[1]),
         D[5] * turn - f.d[2]};
}

// Cosines and sines. The turns within a piece are small as a rule: Taylor's series to x^17, whose
// next term is below 1e-17 there, for all at a time.
void directions(const PhaseElement::Stages& x, PhaseElement::Stages& c, PhaseElement::Stages& s) {
    constexpr double kSmall = 0.6;
    double largest = 0;
    for (const double v : x) largest = std::max(largest, std::fabs(v));
    for (std::size_t j = 0; j < x.size(); ++j) {
        const double z = x[j] * x[j];
        double p = 1, q = 1;
        for (int k = 16; k >= 2; k -= 2)
            p = 1 - z * p * (1.0 / (k * (k - 1))), q = 1 - z * q * (1.0 / (k * (k + 1)));
        c[j] = p, s[j] = x[j] * q;
    }
    if (largest <= kSmall) return;
    for (std::size_t j = 0; j < x.size(); ++j) c[j] = std::cos(x[j]), s[j] = std::sin(x[j]);
}

}  // namespace

PhaseElement::PhaseElement(const Robot& robot, const Ground& ground, const GaitTable& table,
                           double omega, double tau, double h, BodyShape& shape)
    : h_(h), omega_(omega) {
    const Rule& rule = Rule::get();
    const auto at = [&](double phase, Mat3& A, Vec3& b, double& spin, double& recoil) {
        shape.set(robot, table, std::sin(phase), std::cos(phase), false);
        linear_part(shape, robot, ground, omega, A, b);
        spin = 1 / (omega * shape.J), recoil = shape.K / shape.J;
    };
    std::array<Mat3, s> A;
    std::array<Vec3, s> b;
    at(tau, A0_, b0_, spin0_, recoil0_);
    for (int k = 0; k < s; ++k) at(tau + h * rule.c[k], A[k], b[k], spin_[k], recoil_[k]);
    J_ = shape.J;
    tabulate(A, b);
    Mat3 implicit = identity3();
    for (int i = 0; i < 9; ++i) implicit[i] -= h * rule.bump_height * A0_[i];
    filter_ = identity3();
    solve_dense<3, 3>(implicit.data(), filter_.data());
}

// Stage (c, j), component c of stage j, is unknown number c s + j.
void PhaseElement::tabulate(const std::array<Mat3, s>& A, const std::array<Vec3, s>& b) {
    constexpr int columns = 4 + 2 * s;
    const Rule& rule = Rule::get();
    std::array<double, N * N> M{};
    std::array<double, N * columns> right{};
    for (int c = 0; c < 3; ++c)
        for (int j = 0; j < s; ++j) {
            const int row = c * s + j;
            double* r = &right[row * columns];
            r[c] = 1;
            for (int k = 0; k < s; ++k) {
                const double ha = h_ * rule.a[j * s + k];
                for (int d = 0; d < 3; ++d) M[row * N + d * s + k] -= ha * A[k][3 * c + d];
                r[3] += ha * b[k][c];
                if (c < 2) r[4 + c * s + k] = ha;
            }
            M[row * N + row] += 1;
        }
    solve_dense<N, columns>(M.data(), right.data());
    for (int row = 0; row < N; ++row) {
        const double* r = &right[row * columns];
        for (int c = 0; c < 3; ++c) from_[c][row] = r[c];
        rest_[row] = r[3];
        for (int c = 0; c < 2 * s; ++c) swirl_[c][row] = r[4 + c];
    }
}

void PhaseElement::swirl(const std::array<Stages, count>& Y, std::array<Stages, 2>& q) const {
    for (int k = 0; k < s; ++k) {
        const double turn = spin_[k] * Y[L][k];
        q[0][k] = turn * Y[Vy][k], q[1][k] = -turn * Y[Vx][k];
    }
}

bool PhaseElement::solve(double slack, Solution& to) {
    constexpr int kMost = 30;
    constexpr double kRounding = 1e-15;
    const auto& y0 = to.start;
    std::array<double, N> base = rest_, Y;
    for (int c = 0; c < 3; ++c)
        for (int i = 0; i < N; ++i) base[i] += from_[c][i] * y0[c];
    if (!visited_)
        for (int k = 0; k < s; ++k)
            q_[0][k] = spin_[k] * y0[L] * y0[Vy], q_[1][k] = -spin_[k] * y0[L] * y0[Vx];
    visited_ = true;
    for (int iteration = 0; iteration < kMost; ++iteration) {
        Y = base;
        for (int c = 0; c < 2 * s; ++c) {
            const double q = q_[c / s][c % s];
            for (int i = 0; i < N; ++i) Y[i] += swirl_[c][i] * q;
        }
        for (int c = 0; c < 3; ++c) std::copy_n(&Y[c * s], s, to.stage[c].begin());
        std::array<Stages, 2> next;
        swirl(to.stage, next);
        double change = 0, size = 0;
        for (int c = 0; c < 2; ++c)
            for (int k = 0; k < s; ++k) {
                change = std::max(change, std::fabs(next[c][k] - q_[c][k]));
                size = std::max(size, std::fabs(next[c][k]));
            }
        q_ = next;
        if (!(h_ * size < 1e300)) break;
        if (h_ * change > std::max(slack, kRounding * h_ * size)) continue;
        follow(to);
        defects(to);
        return true;
    }
    visited_ = false;
    return false;
}

// Angle and place: integrals of what is known by now.
void PhaseElement::follow(Solution& to) const {
    const Rule& rule = Rule::get();
    const double dt = h_ / omega_;
    Stages w, vx, vy;
    for (int k = 0; k < s; ++k) w[k] = h_ * (spin_[k] * to.stage[L][k] - recoil_[k]);
    Stages& turn = to.stage[angle];
    for (int j = 0; j < s; ++j) {
        turn[j] = 0;
        for (int k = 0; k < s; ++k) turn[j] += rule.a[j * s + k] * w[k];
    }
    Stages c, n;
    directions(turn, c, n);
    for (int j = 0; j < s; ++j) {
        vx[j] = dt * (c[j] * to.stage[Vx][j] - n[j] * to.stage[Vy][j]);
        vy[j] = dt * (n[j] * to.stage[Vx][j] + c[j] * to.stage[Vy][j]);
    }
    for (int j = 0; j < s; ++j) {
        double px = 0, py = 0;
        for (int k = 0; k < s; ++k)
            px += rule.a[j * s + k] * vx[k], py += rule.a[j * s + k] * vy[k];
        to.stage[x][j] = px, to.stage[y][j] = py;
    }
}

// Rate of the polynomial through start and stages, less the rate of the motion, at the start.
void PhaseElement::defects(Solution& to) const {
    const Rule& rule = Rule::get();
    const auto& y0 = to.start;
    const double dt = h_ / omega_, turn = spin0_ * y0[L];
    const double rate[count] = {
        h_ * (A0_[0] * y0[0] + A0_[1] * y0[1] + A0_[2] * y0[2] + b0_[0] + turn * y0[Vy]),
        h_ * (A0_[3] * y0[0] + A0_[4] * y0[1] + A0_[5] * y0[2] + b0_[1] - turn * y0[Vx]),
        h_ * (A0_[6] * y0[0] + A0_[7] * y0[1] + A0_[8] * y0[2] + b0_[2]),
        h_ * (turn - recoil0_),
        dt * y0[Vx],
        dt * y0[Vy]};
    for (int c = 0; c < count; ++c) {
        double slope = 0;
        for (int k = 0; k < s; ++k) slope += rule.slope0[k] * (to.stage[c][k] - y0[c]);
        to.defect[c] = slope - rate[c];
    }
    const Vec3 motion = multiply(filter_, Vec3{to.defect[0], to.defect[1], to.defect[2]});
    std::copy(motion.begin(), motion.end(), to.defect.begin());
}

}  // namespace serpenoid
