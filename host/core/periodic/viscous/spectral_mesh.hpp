// Equally spaced phases of half a cycle: derivatives, integrals and interpolation by its modes.
//
// N nodes, N even, of [0, pi). A function that repeats each half cycle (even) has the modes 0, 2,
// ..., N - 2, and N, whose derivative is zero at the nodes. One that changes its sign (odd) has 1,
// 3, ..., N - 1.
#pragma once

#include <vector>

#include "periodic/viscous/spectral_row.hpp"

namespace serpenoid {

struct SpectralMesh {
    int nodes;
    double step;                                // of phase
    std::vector<double> sine, cosine;           // of the nodes
    std::vector<SpectralRow> rows;              // by row minus column, from 1 - nodes on
    std::vector<FoldedRow> folded;              // [row < nodes/2][pair <= nodes/2]
    std::vector<double> even_slope, odd_slope;  // the rows' derivatives once more, side by side
    std::vector<double> modes;                  // [node][8]: CycleTask of cycle_table.hpp has them
    std::vector<double> stencil;                // likewise
    std::vector<double> even_half,
        odd_half;  // at the middle of a cell, by cell minus node, likewise

    // Meshes of 12, 24, 48 and 96 nodes, which all threads share.
    static constexpr int kLevels = 4, kCoarsest = 12;
    static const SpectralMesh& level(int k);

  private:
    explicit SpectralMesh(int nodes);
    void matrices();
    void fold();
    void local_polynomial();
};

}  // namespace serpenoid
