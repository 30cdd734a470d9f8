// The integral of the positive part of a function from its values at equally spaced points.
#pragma once

#include <algorithm>
#include <cmath>

namespace serpenoid {

// The integral from 0 to x of max(q, 0) for the parabola q with the given values at 0, 1/2 and 1.
// It sums the positive ones of the integrals between the roots.
inline double positive_integral(double start, double middle, double end, double x = 1) {
    const double slope = 4 * middle - 3 * start - end;
    const double curvature = 2 * start + 2 * end - 4 * middle;
    const auto primitive = [&](double z) {
        return z * (start + z * (slope / 2 + z * curvature / 3));
    };
    double first = 0;
    double second = 0;
    const double discriminant = slope * slope - 4 * curvature * start;
    if (discriminant > 0) {
        const double half = -(slope + std::copysign(std::sqrt(discriminant), slope)) / 2;
        const double root = std::clamp(half / curvature, 0.0, x);
        const double second_root = std::clamp(start / half, 0.0, x);
        first = primitive(std::min(root, second_root));
        second = primitive(std::max(root, second_root));
    }
    return std::max(first, 0.0) + std::max(second - first, 0.0) +
           std::max(primitive(x) - second, 0.0);
}

// The mean of the positive part over an interval with five samples, and an estimate of its error
// from panels of double width: the error of a parabola, also at a kink, is of order 4 in its width.
struct PositiveMean {
    explicit PositiveMean(const double* p)
        : value((positive_integral(p[0], p[1], p[2]) + positive_integral(p[2], p[3], p[4])) / 2),
          error(std::fabs(value - positive_integral(p[0], p[2], p[4])) / kErrorRatio),
          net((7 * (p[0] + p[4]) + 32 * (p[1] + p[3]) + 12 * p[2]) / 90) {}

    double value;
    double error;
    double net;  // mean of both signs, by Boole's rule

  private:
    static constexpr double kErrorRatio =
        8;  // error with double width over the error; 16 in the limit
};

}  // namespace serpenoid
