// What kernels read of a spectral mesh; nothing from std, as kernels are compiled for processors.
#pragma once

namespace serpenoid {

// Rows of circulant matrices for one row minus column, 1 - nodes to nodes - 1: derivative and
// integral to the next node, of what repeats each half cycle (even) and of what changes its sign.
struct SpectralRow {
    double even_slope, odd_slope, even_integral, odd_integral;
};

}  // namespace serpenoid
