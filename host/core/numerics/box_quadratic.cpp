// The active-set method of box_quadratic.hpp.
#include "numerics/box_quadratic.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>

#include "numerics/cholesky.hpp"

namespace serpenoid {

namespace {

using Vector = std::vector<double>;
constexpr struct {
    double inside = 1 - 1e-15;  // share of a bound that is not at it yet: a few units of rounding
    double rounding = 1e-13;    // rounding of the sums, as a share of the largest number
    // Share of a diagonal that is added to it, for the smallest of many solutions. Three
    // refinements undo it to rounding.
    double regularisation = 1e-9;
} kBoxLimits;

}  // namespace

// Solve matrix_ x_ = right_ with a slightly larger diagonal, and refine three times by the
// residual. From zero this converges to the solution of least norm, exact to rounding if there is a
// solution. residual_ holds the residual.
void BoxQuadratic::solve(double regularisation) {
    const std::size_t size = right_.size();
    const int rows = static_cast<int>(size);
    // The larger ones are for a matrix that rounding makes indefinite.
    for (double addition : {regularisation, 1e-6, 1e-3}) {
        factor_ = matrix_;
        for (std::size_t i = 0; i < size; ++i) factor_[i * size + i] *= 1 + addition;
        cholesky(factor_.data(), rows);
        if (size == 0 || std::isfinite(factor_.back())) break;
    }
    x_.assign(size, 0.0);
    const auto residual = [&] {
        residual_ = right_;
        for (std::size_t i = 0; i < size; ++i)
            for (std::size_t j = 0; j < size; ++j) residual_[i] -= matrix_[i * size + j] * x_[j];
    };
    for (int refinement = 0; refinement < 3; ++refinement) {
        residual();
        forward(factor_.data(), rows, residual_.data());
        backward(factor_.data(), rows, residual_.data());
        for (std::size_t i = 0; i < size; ++i) x_[i] += residual_[i];
    }
    residual();
}

void BoxQuadratic::minimise_free(const Vector& A, const Vector& b, Vector& z) {
    matrix_ = A;
    right_ = b;
    for (double& r : right_) r = -r;
    solve(kBoxLimits.regularisation);
    z = x_;
}

// If the matrix is nearly singular, solve() may not reach the minimum, and bounds are freed and
// fixed without end. A smaller regularisation then finds it.
bool BoxQuadratic::minimise(const Vector& A, const Vector& b, Vector& z) {
    return descend(A, b, z, kBoxLimits.regularisation) ||
           descend(A, b, z, 1e-4 * kBoxLimits.regularisation);
}

bool BoxQuadratic::descend(const Vector& A, const Vector& b, Vector& z, double regularisation) {
    const std::size_t n = b.size();
    double scale = 1e-300;
    for (std::size_t i = 0; i < n; ++i) scale = std::max({scale, A[i * n + i], std::fabs(b[i])});
    const auto slope = [&](std::size_t i) {
        return std::inner_product(z.begin(), z.end(), A.begin() + static_cast<long>(i * n), b[i]);
    };
    const auto rounding = [&](std::size_t i) {
        return kBoxLimits.rounding * std::sqrt(scale * A[i * n + i]);
    };
    const auto larger = [](double a, double b) { return std::fabs(a) < std::fabs(b); };
    free_.clear();
    for (std::size_t i = 0; i < n; ++i) {
        z[i] = std::clamp(z[i], -1.0, 1.0);
        if (std::fabs(z[i]) < 1) free_.push_back(static_cast<int>(i));
    }
    for (std::size_t moves = 0; moves < 100 + 20 * n; ++moves) {
        const std::size_t size = free_.size();
        matrix_.resize(size * size);
        right_.resize(size);
        for (std::size_t i = 0; i < size; ++i) {
            right_[i] = -b[free_[i]];
            for (std::size_t j = 0; j < n; ++j)
                if (std::fabs(z[j]) == 1) right_[i] -= A[free_[i] * n + j] * z[j];
            for (std::size_t j = 0; j < size; ++j)
                matrix_[i * size + j] = A[free_[i] * n + free_[j]];
        }
        solve(regularisation);
        // If the system has no solution, the objective falls without limit along the residual.
        double inconsistency = 0;
        for (std::size_t i = 0; i < size; ++i) {
            inconsistency = std::max(inconsistency, std::fabs(residual_[i]) / rounding(free_[i]));
            residual_[i] /= matrix_[i * size + i];
        }
        if (inconsistency > 1) {
            const double distance =
                4 / std::fabs(*std::max_element(residual_.begin(), residual_.end(), larger));
            for (std::size_t i = 0; i < size; ++i) x_[i] = z[free_[i]] + distance * residual_[i];
        }
        double part = 1;
        int stop = -1;
        for (std::size_t i = 0; i < size; ++i) {
            const double start = z[free_[i]], goal = x_[i];
            if (std::fabs(goal) <= 1) continue;
            const double fraction = (std::copysign(1.0, goal) - start) / (goal - start);
            if (fraction < part || stop < 0) {
                part = std::min(part, fraction);
                stop = static_cast<int>(i);
            }
        }
        for (std::size_t i = 0; i < size; ++i) {
            double& goal = z[free_[i]];
            goal = std::clamp(goal + part * (x_[i] - goal), -kBoxLimits.inside, kBoxLimits.inside);
        }
        if (stop >= 0) {
            z[free_[stop]] = std::copysign(1.0, x_[stop]);
            free_.erase(free_.begin() + stop);
            continue;
        }
        int worst = -1;
        double largest_pull = 1;
        for (std::size_t i = 0; i < n; ++i) {
            if (std::fabs(z[i]) != 1) continue;
            const double pull = z[i] * slope(i) / rounding(i);
            if (pull > largest_pull) {
                largest_pull = pull;
                worst = static_cast<int>(i);
            }
        }
        if (worst < 0) return true;
        free_.push_back(worst);
        z[worst] *= kBoxLimits.inside;
    }
    return false;
}

}  // namespace serpenoid
