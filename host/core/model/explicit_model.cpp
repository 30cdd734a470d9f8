// The exact (explicit) model for any number of links; derivations in explicit_model.hpp.
#include "model/explicit_model.hpp"

#include "model/joint_sums.hpp"
#include "numerics/dense.hpp"

namespace serpenoid {

// The names are those of explicit_model.hpp: r, b and s'' (turn_accel) of link i, half_ and
// last_half_ for half of this link and of the previous one; the sums are over all links.
TailMotion tail_motion(const Robot& robot, const double* joint_accel, Chain& k) {
    const double l = robot.l, m = robot.m, mass = robot.n * m, per_link = 1.0 / robot.n;
    double fx = k.fx[0], fy = k.fy[0], moment = 0, sum_rx = 0, sum_ry = 0, sum_r_square = 0,
           sum_turn_accel = 0;
    double rx = 0, ry = 0, b_x = 0, b_y = 0, turn_accel = 0;
    double last_half_x = l * k.c[0], last_half_y = l * k.s[0];
    const double first_rate_square = k.omega[0] * k.omega[0];
    double last_half_b_x = -first_rate_square * last_half_x,
           last_half_b_y = -first_rate_square * last_half_y;
    k.ax[0] = 0;
    k.ay[0] = 0;
    k.alpha[0] = 0;
    for (int i = 1; i < k.n(); ++i) {
        turn_accel += joint_accel[i - 1];
        const double rate_square = k.omega[i] * k.omega[i];
        const double half_x = l * k.c[i], half_y = l * k.s[i];  // half a link
        const double half_b_x = -turn_accel * half_y - rate_square * half_x;
        const double half_b_y = turn_accel * half_x - rate_square * half_y;
        rx += last_half_x + half_x;
        ry += last_half_y + half_y;
        b_x += last_half_b_x + half_b_x;
        b_y += last_half_b_y + half_b_y;
        last_half_x = half_x;
        last_half_y = half_y;
        last_half_b_x = half_b_x;
        last_half_b_y = half_b_y;
        k.ax[i] = b_x;
        k.ay[i] = b_y;
        k.alpha[i] = turn_accel;
        const double gx = k.fx[i] - m * b_x, gy = k.fy[i] - m * b_y;
        fx += gx;
        fy += gy;
        moment += rx * gy - ry * gx;
        sum_rx += rx;
        sum_ry += ry;
        sum_r_square += rx * rx + ry * ry;
        sum_turn_accel += turn_accel;
    }
    // Elimination of x'' and y'' leaves the inertia about the centre of mass.
    const double J =
        robot.n * robot.I + m * (sum_r_square - per_link * (sum_rx * sum_rx + sum_ry * sum_ry));
    const double alpha =
        (moment - robot.I * sum_turn_accel + per_link * (sum_ry * fx - sum_rx * fy)) / J;
    return {(fx + m * sum_ry * alpha) / mass, (fy - m * sum_rx * alpha) / mass, alpha};
}

void explicit_angle(const Robot& robot, const double* joint_accel, Chain& k) {
    const TailMotion tail = tail_motion(robot, joint_accel, k);
    for (int i = 0; i < k.n(); ++i) {
        const double rx = k.x[i] - k.x[0], ry = k.y[i] - k.y[0];
        k.ax[i] += tail.ax - tail.alpha * ry;
        k.ay[i] += tail.ay + tail.alpha * rx;
        k.alpha[i] += tail.alpha;
    }
}

void joint_forces(const Robot& robot, const Chain& k, Joints& joints) {
    JointSums tail_part;
    for (int i = 0; i + 1 < k.n(); ++i) {
        tail_part.add(robot, -k.s[i], k.c[i], k.ax[i], k.ay[i], k.alpha[i], k.fx[i], k.fy[i]);
        joints.Fx[i] = tail_part.Fx;
        joints.Fy[i] = tail_part.Fy;
        joints.T[i] = tail_part.T;
    }
}

// Accelerations of the links from the forces and torques of all joints (Eqs. 1-9).
static void accelerate(const Robot& r, Chain& k, const Joints& joints) {
    double px = 0, py = 0, pT = 0;  // F_x, F_y, T of the previous joint; q: of the next one
    for (int i = 0; i < k.n(); ++i) {
        const bool is_head = i + 1 == k.n();
        const double qx = is_head ? 0 : joints.Fx[i], qy = is_head ? 0 : joints.Fy[i];
        const double qT = is_head ? 0 : joints.T[i];
        k.ax[i] = (k.fx[i] + qx - px) / r.m;
        k.ay[i] = (k.fy[i] + qy - py) / r.m;
        k.alpha[i] = (qT - pT + r.l * (-k.s[i] * (px + qx) + k.c[i] * (py + qy))) / r.I;
        px = qx;
        py = qy;
        pT = qT;
    }
}

namespace {

// The three rows of joint i, each over (F_x, F_y, T) of joints i - 1, i, i + 1, and the right side.
struct JointRows {
    double previous[9], diagonal[9], next[9], right[3];
};

// Equations of joint i. joint_input is phi'' of an imposed joint and T* of a free one: the torque
// on its rotor, so that phi'' = (T - T*) / rotor, or without a rotor its torque T.
JointRows joint_rows(const Robot& r, const Chain& k, int i, bool imposed, double rotor,
                     double joint_input) {
    const double im = 1 / r.m, lI = r.l / r.I, ll = r.l * lI, iI = 1 / r.I;
    const double a[2] = {-k.s[i], k.c[i]}, b[2] = {-k.s[i + 1], k.c[i + 1]};  // n_i, n_{i+1}
    const double wi = r.l * k.omega[i] * k.omega[i];
    const double wj = r.l * k.omega[i + 1] * k.omega[i + 1];
    JointRows rows{};
    for (int p = 0; p < 2; ++p) {
        for (int q = 0; q < 2; ++q) {
            const double inverse_mass = p == q ? im : 0;
            rows.previous[3 * p + q] = ll * a[p] * a[q] - inverse_mass;
            rows.diagonal[3 * p + q] = ll * (a[p] * a[q] + b[p] * b[q]) + 2 * inverse_mass;
            rows.next[3 * p + q] = ll * b[p] * b[q] - inverse_mass;
        }
        rows.previous[3 * p + 2] = -lI * a[p];
        rows.diagonal[3 * p + 2] = lI * (a[p] - b[p]);
        rows.next[3 * p + 2] = lI * b[p];
    }
    rows.right[0] = (k.fx[i + 1] - k.fx[i]) * im + k.c[i] * wi + k.c[i + 1] * wj;
    rows.right[1] = (k.fy[i + 1] - k.fy[i]) * im + k.s[i] * wi + k.s[i + 1] * wj;
    rows.right[2] = imposed ? -joint_input : rotor > 0 ? joint_input / rotor : joint_input;
    if (!imposed && rotor == 0) {
        rows.diagonal[8] = 1;
        return rows;
    }
    for (int q = 0; q < 2; ++q) {
        rows.previous[6 + q] = lI * a[q];
        rows.diagonal[6 + q] = lI * (a[q] - b[q]);
        rows.next[6 + q] = -lI * b[q];
    }
    rows.previous[8] = -iI;
    rows.next[8] = -iI;
    rows.diagonal[8] = 2 * iI + (imposed ? 0 : 1 / rotor);
    return rows;
}

}  // namespace

void explicit_mixed(const Robot& robot, const std::vector<char>& imposed,
                    const std::vector<double>& rotor, const double* joint_accel, Chain& k,
                    Joints& joints) {
    const int last = k.n() - 2;
    std::vector<double> upper(9 * (last + 1));
    std::vector<Vec3> solution(last + 1);
    for (int i = 0; i <= last; ++i) {
        JointRows rows = joint_rows(robot, k, i, imposed[i], rotor[i],
                                    imposed[i] ? joint_accel[i] : joints.T[i]);
        double rhs[12];  // (block to the next joint, right side)
        for (int p = 0; p < 3; ++p) {
            for (int q = 0; q < 3; ++q) rhs[4 * p + q] = i < last ? rows.next[3 * p + q] : 0;
            rhs[4 * p + 3] = rows.right[p];
            for (int j = 0; j < 3 && i > 0; ++j) {  // eliminate the previous joint
                const double f = rows.previous[3 * p + j];
                for (int q = 0; q < 3; ++q)
                    rows.diagonal[3 * p + q] -= f * upper[9 * (i - 1) + 3 * j + q];
                rhs[4 * p + 3] -= f * solution[i - 1][j];
            }
        }
        solve_dense<3, 4>(rows.diagonal, rhs);
        for (int p = 0; p < 3; ++p) {
            for (int q = 0; q < 3; ++q) upper[9 * i + 3 * p + q] = rhs[4 * p + q];
            solution[i][p] = rhs[4 * p + 3];
        }
    }
    for (int i = last; i >= 0; --i) {
        for (int p = 0; p < 3 && i < last; ++p)
            for (int q = 0; q < 3; ++q)
                solution[i][p] -= upper[9 * i + 3 * p + q] * solution[i + 1][q];
        joints.Fx[i] = solution[i][0];
        joints.Fy[i] = solution[i][1];
        joints.T[i] = solution[i][2];
    }
    accelerate(robot, k, joints);
}

}  // namespace serpenoid
