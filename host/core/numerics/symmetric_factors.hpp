// The factors L D L^T of a symmetric matrix, real or complex, with few entries beside its diagonal.
#pragma once

#include <algorithm>
#include <cmath>
#include <complex>
#include <vector>

namespace serpenoid {

// Each row is kept from its first entry to the diagonal. Without pivoting, which a matrix with a
// positive definite real part does not need.
template <class Scalar>
class SymmetricFactors {
  public:
    // `first`: the first column of each row that may have an entry.
    explicit SymmetricFactors(const std::vector<int>& first) : first_(first) {
        int size = 0;
        for (std::size_t row = 0; row < first.size(); ++row) {
            begin_.push_back(size - first[row]);
            size += static_cast<int>(row) + 1 - first[row];
        }
        entries_.resize(size);
    }
    void clear() { std::fill(entries_.begin(), entries_.end(), Scalar{}); }
    Scalar& entry(int row, int column) { return entries_[begin_[row] + column]; }

    bool factor() {
        for (int row = 0; row < rows(); ++row) {
            Scalar* entries = &entries_[begin_[row]];
            for (int column = first_[row]; column < row; ++column) {
                const Scalar* above = &entries_[begin_[column]];
                for (int k = std::max(first_[row], first_[column]); k < column; ++k)
                    entries[column] -= entries[k] * above[k];
            }
            for (int column = first_[row]; column < row; ++column) {
                const Scalar scaled = entries[column];
                entries[column] *= entry(column, column);
                entries[row] -= scaled * entries[column];
            }
            if (!(std::norm(entries[row]) > 0)) return false;
            entries[row] = Scalar{1} / entries[row];
        }
        return true;
    }
    void solve(std::vector<Scalar>& x) const {
        for (int row = 0; row < rows(); ++row)
            for (int k = first_[row]; k < row; ++k) x[row] -= entries_[begin_[row] + k] * x[k];
        for (int row = rows() - 1; row >= 0; --row) x[row] *= entries_[begin_[row] + row];
        for (int row = rows() - 1; row >= 0; --row)
            for (int k = first_[row]; k < row; ++k) x[k] -= entries_[begin_[row] + k] * x[row];
    }

  private:
    int rows() const { return static_cast<int>(first_.size()); }
    std::vector<int> first_, begin_;  // begin_: where a row's column 0 would be
    std::vector<Scalar> entries_;     // of the diagonal, once it is factored, the inverse of D
};

}  // namespace serpenoid
