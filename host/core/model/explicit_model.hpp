// The exact (explicit) model for any number of links, O(n), driven by joint angles or by torques.
#pragma once

#include "model/chain.hpp"

namespace serpenoid {

// These take a chain whose angles, rates, positions, velocities, directions and friction are
// filled, and fill its accelerations or the forces and torques of the joints.

// Acceleration of link 1.
struct TailMotion {
    double ax, ay, alpha;
};

// Joint angles imposed: `joint_accel[j]` = phi_j'' for j = 0..n-2; three equations, summed link by
// link. The chain gets b_i and s_i'' in place of its accelerations.
// With r_i = c_i - c_1, s_i'' = sum of phi_j'' for j < i, and
//     a_i = a_1 + theta_1'' z x r_i + b_i,   b_1 = 0,
//     b_{i+1} = b_i + l(s_i'' n_i - w_i^2 t_i + s_{i+1}'' n_{i+1} - w_{i+1}^2 t_{i+1}),
// the sums of force and of moment about c_1 over all links are
//     nm x'' - m R_y theta_1'' = sum f_x - m B_x,    nm y'' + m R_x theta_1'' = sum f_y - m B_y,
//     m (R_x y'' - R_y x'') + J theta_1'' = sum r x (f - m b) - I sum s'',
// R = sum r, B = sum b, J = n I + m sum |r|^2; x'' and y'' are eliminated first.
TailMotion tail_motion(const Robot& robot, const double* joint_accel, Chain& chain);

// The same, and the accelerations of all links.
void explicit_angle(const Robot& robot, const double* joint_accel, Chain& chain);

// The forces and torques behind the accelerations that the chain has.
void joint_forces(const Robot& robot, const Chain& chain, Joints& joints);

// Some joints imposed (imposed[j]: joint_accel[j] = phi_j'' is input, its torque is found), the
// others free (joints.T[j] is input). Equal accelerations of both sides of each joint and, for an
// imposed one, the difference of both links' angular equations give a block-tridiagonal system of
// three unknowns a joint, with N = n n^T and tau_i = T_i - T_{i-1}:
//     (2F_i - F_{i-1} - F_{i+1})/m + (l^2/I)[N_i (F_{i-1} + F_i) + N_{i+1} (F_i + F_{i+1})]
//   = (f_{i+1} - f_i)/m - (l/I)(n_i tau_i + n_{i+1} tau_{i+1}) + l(t_i w_i^2 + t_{i+1} w_{i+1}^2),
//     (2T_i - T_{i-1} - T_{i+1})/I + (l/I)[n_i . (F_{i-1} + F_i) - n_{i+1} . (F_i + F_{i+1})]
//   = -phi_i''.
// A free joint with rotor[j] > 0, the inertia of a motor times its gear ratio squared, has that row
// too: joints.T[j] is the torque T* on the rotor, T_j = T*_j + rotor_j phi_j'' is found.
void explicit_mixed(const Robot& robot, const std::vector<char>& imposed,
                    const std::vector<double>& rotor, const double* joint_accel, Chain& chain,
                    Joints& joints);

}  // namespace serpenoid
