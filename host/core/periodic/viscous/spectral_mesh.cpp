// The matrices of spectral_mesh.hpp, from sums over modes.
#include "periodic/viscous/spectral_mesh.hpp"

#include <array>
#include <cmath>

namespace serpenoid {

const SpectralMesh& SpectralMesh::level(int k) {
    static const std::array<SpectralMesh, kLevels> all = {kCoarsest, 2 * kCoarsest, 4 * kCoarsest,
                                                          8 * kCoarsest};
    return all[k];
}

SpectralMesh::SpectralMesh(int count) : nodes(count), step(std::numbers::pi / count) {
    const double part = 2.0 / nodes;
    for (int d = 1 - nodes; d < nodes; ++d) {
        const double phase = d * step;
        Row row{{0, 0}, {part * step / 2, 0}, {part / 2, 0}};
        for (int mode = 1; mode < nodes; ++mode) {
            const int odd = mode % 2;
            row.slope[odd] -= part * mode * std::sin(mode * phase);
            row.integral[odd] +=
                part * (std::sin(mode * (phase + step)) - std::sin(mode * phase)) / mode;
            row.middle[odd] += part * std::cos(mode * (phase + step / 2));
        }
        rows.push_back(row);
    }
    for (int mode = 1; mode < nodes; mode += 2)
        for (int k = 0; k < nodes; ++k) modes.push_back(std::polar(part, -mode * k * step));
}

}  // namespace serpenoid
