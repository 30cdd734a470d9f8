// Fifteen equations with four right sides, by packs of columns: a Newton step of sliding_piece.hpp.
#pragma once

#include "kernels/pack.hpp"

namespace serpenoid::kernels {
namespace {

// Rows of 20 numbers, aligned to 64 bytes: 15 of the matrix, one unused, 4 right sides. The
// solution replaces the right sides; the matrix is destroyed. False when it is singular.
template <int W>
class StageSolve {
    using V = Pack<W>;
    static constexpr int n = 15, kRow = 20, kRight = 16, kPacks = kRow / W;

  public:
    static bool run(double* rows) {
        double* row[n];
        for (int i = 0; i < n; ++i) row[i] = rows + kRow * i;
        double inverse[n];
        for (int k = 0; k < n; ++k) {
            pick(row, k);
            const V* from = reinterpret_cast<const V*>(row[k]);
            if (!(__builtin_fabs(row[k][k]) > 0)) return false;
            inverse[k] = 1 / row[k][k];
            for (int i = k + 1; i < n; ++i) {
                const double f = -row[i][k] * inverse[k];
                if (f == 0) continue;
                V* to = reinterpret_cast<V*>(row[i]);
                const V factor = all<V>(f);
                for (int p = k / W; p < kPacks; ++p) to[p] = fused(factor, from[p], to[p]);
            }
        }
        V solution[n][4 / W];
        for (int k = n - 1; k >= 0; --k)
            for (int p = 0; p < 4 / W; ++p) {
                V sum = reinterpret_cast<const V*>(row[k] + kRight)[p];
                for (int j = k + 1; j < n; ++j)
                    sum = fused(all<V>(-row[k][j]), solution[j][p], sum);
                solution[k][p] = sum * all<V>(inverse[k]);
            }
        for (int k = 0; k < n; ++k)
            for (int p = 0; p < 4 / W; ++p)
                reinterpret_cast<V*>(rows + kRow * k + kRight)[p] = solution[k][p];
        return true;
    }

  private:
    // Swap the row with the largest pivot up: pointers only.
    static void pick(double** row, int k) {
        int best = k;
        for (int i = k + 1; i < n; ++i)
            if (__builtin_fabs(row[i][k]) > __builtin_fabs(row[best][k])) best = i;
        double* const chosen = row[best];
        row[best] = row[k], row[k] = chosen;
    }
};

}  // namespace
}  // namespace serpenoid::kernels
