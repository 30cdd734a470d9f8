// The matrices of spectral_mesh.hpp, from sums over modes.
#include "periodic/viscous/spectral_mesh.hpp"

#include <array>
#include <cmath>

namespace serpenoid {

const SpectralMesh& SpectralMesh::level(int k) {
    static const std::array<SpectralMesh, kLevels> all = {
        SpectralMesh(kCoarsest), SpectralMesh(2 * kCoarsest), SpectralMesh(4 * kCoarsest),
        SpectralMesh(8 * kCoarsest)};
    return all[k];
}

SpectralMesh::SpectralMesh(int count) : nodes(count), step(M_PI / count) {
    for (int k = 0; k < nodes; ++k) {
        sine.push_back(std::sin(k * step)), cosine.push_back(std::cos(k * step));
        for (const int mode : {nodes - 2, nodes - 4, nodes - 1, nodes - 3}) {
            modes.push_back(std::cos(mode * k * step));
            modes.push_back(std::sin(mode * k * step));
        }
    }
    matrices();
    fold();
    local_polynomial();
}

void SpectralMesh::matrices() {
    for (int d = 1 - nodes; d < nodes; ++d) {
        const double at = d * step, next = at + step, middle = at + step / 2;
        SpectralRow row{0, 0, step / 2, 0};
        double even = 0.5, odd = 0;
        for (int p = 1; p < nodes; ++p) {
            double& slope = p % 2 ? row.odd_slope : row.even_slope;
            double& integral = p % 2 ? row.odd_integral : row.even_integral;
            slope -= p * std::sin(p * at);
            integral += (std::sin(p * next) - std::sin(p * at)) / p;
            (p % 2 ? odd : even) += std::cos(p * middle);
        }
        const double f = 2.0 / nodes;
        rows.push_back(
            {f * row.even_slope, f * row.odd_slope, f * row.even_integral, f * row.odd_integral});
        even_slope.push_back(rows.back().even_slope);
        odd_slope.push_back(rows.back().odd_slope);
        even_half.push_back(f * even), odd_half.push_back(f * odd);
    }
}

void SpectralMesh::fold() {
    const auto at = [&](int row, int column) { return rows[row - column + nodes - 1]; };
    for (int k = 0; k < nodes / 2; ++k)
        for (int j = 0; j <= nodes / 2; ++j) {
            FoldedRow to{};
            const SpectralRow own = at(k, j);
            if (j < nodes / 2) {
                const SpectralRow other = at(k, nodes - 1 - j);
                for (const int i : {0, 1}) {
                    const double sign = i == 0 ? 1 : -1;
                    to.even_slope[i] = (own.even_slope + sign * other.even_slope) / 2;
                    to.odd_slope[i] = (own.odd_slope + sign * other.odd_slope) / 2;
                }
            }
            if (j == 0) {  // half a cycle later again, or with its sign changed
                to.even_integral[0] = own.even_integral, to.odd_integral[1] = own.odd_integral;
            } else if (j == nodes / 2) {
                to.even_integral[0] = own.even_integral, to.odd_integral[0] = own.odd_integral;
            } else {
                const SpectralRow other = at(k, nodes - j);
                for (const int i : {0, 1}) {
                    const double sign = i == 0 ? 1 : -1;
                    to.even_integral[i] = (own.even_integral + sign * other.even_integral) / 2;
                    to.odd_integral[i] = (own.odd_integral + sign * other.odd_integral) / 2;
                }
            }
            folded.push_back(to);
        }
}

// The polynomial through values at -3, ..., 4 in powers of t, and what it has of Bernoulli's
// numbers: sum of b_j B_{j+1} / (j + 1) with B_1 = 1/2.
void SpectralMesh::local_polynomial() {
    constexpr int wide = 8;
    constexpr double bernoulli[wide] = {1. / 2, 1. / 6, 0, -1. / 30, 0, 1. / 42, 0, -1. / 30};
    stencil.assign(wide * wide + wide, 0);
    for (int j = 0; j < wide; ++j) {
        std::array<double, wide> c{1.0};
        int degree = 0;
        for (int k = 0; k < wide; ++k) {
            if (k == j) continue;
            ++degree;
            for (int p = degree; p >= 0; --p)
                c[p] = ((p > 0 ? c[p - 1] : 0) - (k - 3) * (p < degree ? c[p] : 0)) / (j - k);
        }
        for (int p = 0; p < wide; ++p) {
            stencil[wide * p + j] = c[p];
            stencil[wide * wide + j] += c[p] * bernoulli[p] / (p + 1);
        }
    }
}

}  // namespace serpenoid
