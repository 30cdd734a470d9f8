// Vector kernels of the implicit model with imposed angles: their data and their table.
//
// A pack is as many doubles as one register holds; its lanes are neighbouring links of one robot.
// Each instruction set is a translation unit of its own; the processor decides which one runs.
#pragma once

#include <array>

#include "kernels/cycle_table.hpp"
#include "kernels/stage_table.hpp"
#include "model/params.hpp"

namespace serpenoid::kernels {

enum class Law { viscous, dry, smoothed, ratchet, smoothed_ratchet };
constexpr int kLaws = 5;

// What a row of packs holds; a row stands for `width` links.
enum Row : int {
    kAngleSin,  // theta_i - theta_1 = kAngleSin sin(wt) + kAngleCos cos(wt) + kAngleOffset
    kAngleCos,
    kAngleOffset,
    kStiffness,  // of the joint before each link; 0 where there is none
    kDamping,
    kX,
    kY,
    kVx,
    kVy,
    kStageX,  // place and velocities of a stage
    kStageY,
    kStageVx,
    kStageVy,
    kFirstX,  // acceleration of the first stage; of the second and third, summed
    kFirstY,
    kRestX,
    kRestY,
    kShape,  // three times cos, sin of theta_i - theta_1 and its rate
    kRow = kShape + 9
};

// Single packs: the same value in every lane.
enum One : int {
    kTheta,  // of link 1
    kOmega,
    kGaitOmega,
    kTurnSin,  // sum of theta_i - theta_1 over the links: kTurnSin sin(wt) + kTurnCos cos(wt) + ...
    kTurnCos,
    kTurns,  // the sum's second derivative, at three times
    kOnes = kTurns + 3
};

// What a kernel advances. Memory, aligned to 64 bytes: the single packs, then the rows.
struct Task {
    Robot robot;
    Ground ground;
    Slope slope;
    double smoothing;  // m/s
    int rows;
    double* memory;
    int shape;       // 0 or 2: the shape that the next step begins with
    double shape_s;  // and its time; a NaN before the first step
};

// One step from t to `end`.
using Step = void (*)(Task&, double t, double end);
using Steps = std::array<Step, kLaws>;  // by Law
using Sincos = void (*)(const double* x, double* sine, double* cosine, long packs);

// The kernels of one instruction set.
struct Set {
    const char* name;
    int width;                  // doubles a pack
    std::array<Steps, 2> step;  // on level and on tilted ground
    Sincos sincos;
    CycleKernel cycle;
    StageKernel stage;
};

extern const Set scalar, baseline, avx2, avx512;

}  // namespace serpenoid::kernels
