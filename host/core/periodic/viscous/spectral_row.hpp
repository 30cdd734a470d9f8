// The parts of a spectral mesh that kernels read. Nothing from std: see numerics/pack.hpp.
#pragma once

namespace serpenoid {

// Rows of circulant matrices for one row minus column, 1 - nodes to nodes - 1: derivative and
// integral to the next node, of what repeats each half cycle (even) and of what changes its sign.
struct SpectralRow {
    double even_slope, odd_slope, even_integral, odd_integral;
};

// The same matrices on sums [0] and differences [1] of what stands at a node and at its mirror
// image in the half cycle, for one node or cell and one such pair: half of the products. Values to
// be differentiated have the pairs j and N - 1 - j, j < N/2. Values to be integrated have the pairs
// j and N - j; 0 and N/2 stand alone. The rows k and N - 1 - k get: for slopes [1] + [0] and [1] -
// [0], for integrals [0] + [1] and [0] - [1].
struct FoldedRow {
    double even_slope[2], odd_slope[2], even_integral[2], odd_integral[2];
};

}  // namespace serpenoid
