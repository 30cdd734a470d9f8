// The data of periodic states on viscous ground by packs; spectral.hpp has the derivation.
//
// A pack holds gaits of one shape at different rates, one a lane. They share the tables of the
// shape.
#pragma once

#include "periodic/viscous/spectral_row.hpp"

namespace serpenoid {

// Coefficients at a node of phase, [field][node]: v' = -g (B (v, nu) + b) + nu (v_y, -v_x) and nu'
// = -g (W (v, nu) + w) - j nu - k, g = 1/omega, v = V/omega, nu = theta_1'/omega.
enum NodeField : int {
    kBxx,
    kBxy,
    kBxw,
    kByy,
    kByw,
    kWx,
    kWy,
    kWw,
    kJ1,     // the matrix
    kSlope,  // and its derivatives by tau
    kBx = kSlope + 9,
    kBy,
    kW,
    kK1,     // the constant terms
    kArm2,   // J / (n m), m^2
    kSpin2,  // (K / J)^2
    kLoss,   // dissipation of the chain at rest / (n m)
    kNodeFields
};

// Coefficients of a joint's torque at a node, [joint][field][node]: T/omega^2 is a sum of ten
// products.
enum JointField : int {
    kByAx,
    kByAy,
    kByTurning,
    kBySpin2,
    kBySpin,
    kByShape,  // of the motion
    kByVx,
    kByVy,
    kByNu,
    kByBend,  // of friction, times g
    kRate,    // d phi_i / d tau
    kJointFields
};

constexpr int kLocal = 8;  // nodes of a local polynomial, three before the cell and three after it

// Where a joint's rate changes its sign in a half cycle; the same at all rates of the gait.
struct JointTurn {
    double place;   // in steps from phase 0
    double before;  // sign of the joint's rate before it
    double swing;   // sum of the joint's rate squared over the nodes
    // weights of the values at the cell's eight nodes: for the value there, and for the correction
    // of the integral over half a cycle (cycle_powers.hpp) with sigma = 1
    double value[kLocal], mend[kLocal];
};

// A pack of gaits on a mesh of phases. Packs, in memory aligned to 64 bytes.
struct CycleTask {
    int nodes, joints;
    double step;              // of phase
    const double* node;       // [kNodeFields][nodes]
    const double* joint;      // [joints][kJointFields][nodes]
    const JointTurn* turns;   // [joints]
    const SpectralRow* rows;  // 2 nodes - 1 of them
    const FoldedRow* folded;  // [nodes/2][nodes/2 + 1]
    const double* modes;      // [nodes][8]: of the last two pairs of even and of odd modes
    const double* stencil;    // [8][8]: powers of the place in a cell, in steps, by the values at
                              // eight nodes, three before the cell; then [8]: see cycle_powers.hpp
    const double* g;          // 1/omega, one pack
    double* y;                // [nodes][3]: v_x, v_y, nu
    double* work;             // kWork packs a node
    static constexpr int kWork = 40;
};

// Results, one pack each.
enum CycleOut : int {
    kChange2,  // squares of the last change and of the speeds, summed over nodes
    kSize2,
    kTransfer,                 // over half a cycle, nine
    kAdvance = kTransfer + 9,  // mean velocity along the path, per omega
    kHeading,                  // of link 1 at phase 0 from the direction of the path
    kDissipated,               // mean, per n m omega^2
    kTail,                     // size of the last modes, as a square beside kSize2
    kLogRadius,                // binary logarithm, of half a cycle's multiplier
    kMeanAbsPower,             // mean of sum |T phi'| / omega^3
    kMeanAbsPowerError,
    kCycleOuts
};

}  // namespace serpenoid
