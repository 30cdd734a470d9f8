// Equally spaced phases of half a cycle: derivatives, integrals and interpolation by its modes.
//
// N nodes, N even, of [0, pi). A function that repeats each half cycle (even) has the modes 0, 2,
// ..., N - 2, and N, whose derivative is zero at the nodes. One that changes its sign (odd) has 1,
// 3, ..., N - 1.
#pragma once

#include <complex>
#include <numbers>
#include <vector>

namespace serpenoid {

struct SpectralMesh {
    // Weights of a node for what is wanted at another one: the derivative there, the integral from
    // there to the next node, and the value half way to it. Of even functions [0], and of odd ones.
    struct Row {
        double slope[2], integral[2], middle[2];
    };
    int nodes;
    double step;                              // of phase
    std::vector<Row> rows;                    // by target node minus node, from 1 - nodes on
    std::vector<std::complex<double>> modes;  // [mode][node]: coefficients of 1, 3, ... by values

    const Row& row(int target, int node) const { return rows[target - node + nodes - 1]; }

    // Meshes of 12, 24, 48 and 96 nodes, which all threads share.
    static constexpr int kLevels = 4, kCoarsest = 12;
    static const SpectralMesh& level(int k);

  private:
    SpectralMesh(int nodes);
};

}  // namespace serpenoid
