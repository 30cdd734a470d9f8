// A root of a function of one number, between two places where its signs differ.
#pragma once

#include <cmath>

namespace serpenoid {

// Root of f between a and b, where fa and fb differ in sign (Illinois' regula falsi), to `near` it.
template <class Function>
double bracketed_root(const Function& f, double a, double fa, double b, double fb,
                      double tolerance) {
    for (int i = 0; i < 60 && std::fabs(b - a) > 1e-15; ++i) {
        const double x = b - fb * (b - a) / (fb - fa), fx = f(x);
        if (std::fabs(fx) <= tolerance) return x;
        if ((fx > 0) == (fb > 0))
            fa *= 0.5;
        else {
            a = b;
            fa = fb;
        }
        b = x;
        fb = fx;
    }
    return b;
}

}  // namespace serpenoid
