// The linear equations of an implicit step, as Newton's iteration solves them.
#pragma once

#include <complex>

namespace serpenoid {

// With a the second derivatives of the coordinates q, v their rates, and s a multiple of 1/h, these
// are
//     (s - da/dv - (da/dq) / s) change = residual
// for one real and one complex s.
class StepEquations {
  public:
    using Complex = std::complex<double>;
    virtual ~StepEquations() = default;

    // Take the derivatives at a state; false where one of the matrices is singular.
    virtual bool linearise(double t, const double* y, double real_s, Complex complex_s) = 0;
    // The residual becomes the change.
    virtual void solve(double* change) = 0;
    virtual void solve(Complex* change) = 0;
};

}  // namespace serpenoid
