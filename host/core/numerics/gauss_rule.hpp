// Gauss-Legendre quadrature on [0, 1]: nodes and weights.
#pragma once

#include <array>
#include <cmath>
#include <numbers>

namespace serpenoid {

// s nodes: exact to degree 2s - 1.
template <int s>
struct Gauss {
    std::array<double, s> c, b;

    static const Gauss& get() {
        static const Gauss instance;
        return instance;
    }

  private:
    Gauss() {
        for (int i = 0; i < s; ++i) node(i);
    }

    // The i-th root of the Legendre polynomial P_s by Newton's method, and its weight.
    void node(int i) {
        double x = -std::cos(std::numbers::pi * (i + 0.75) / (s + 0.5)), slope = 1;
        for (int iteration = 0; iteration < 100; ++iteration) {
            double p0 = 1, p1 = x;
            for (int k = 2; k <= s; ++k) {
                const double p2 = ((2 * k - 1) * x * p1 - (k - 1) * p0) / k;
                p0 = p1;
                p1 = p2;
            }
            slope = s * (x * p1 - p0) / (x * x - 1);
            const double step = p1 / slope;
            x -= step;
            if (std::fabs(step) < 1e-16) break;
        }
        c[i] = (1 + x) / 2;
        b[i] = 1 / ((1 - x * x) * slope * slope);
    }
};

}  // namespace serpenoid
