// Minimum of a convex quadratic over a box; used for forces of contacts at rest, each with a bound.
//
//     minimise  1/2 z.A z + b.z  over |z_i| <= 1,     A symmetric, positive semidefinite.
//
// A is singular if there are more contacts than equations of rest. Then the solution of least norm
// is taken, which spreads the load. Active-set method: some z_i are fixed at their bounds. Move
// towards the minimum over the free z_i, as far as the box allows, and fix the z_i that reaches its
// bound. At the minimum, free the fixed z_i with the largest gradient into the box. The objective
// falls at every move.
#pragma once

#include <vector>

namespace serpenoid {

class BoxQuadratic {
  public:
    // A is given by rows. z holds the starting point, then the minimum. Returns false if rounding
    // errors make the method cycle.
    bool minimise(const std::vector<double>& A, const std::vector<double>& b,
                  std::vector<double>& z);

    // The z of least norm among those that minimise the quadratic without bounds.
    void minimise_free(const std::vector<double>& A, const std::vector<double>& b,
                       std::vector<double>& z);

  private:
    bool descend(const std::vector<double>& A, const std::vector<double>& b, std::vector<double>& z,
                 double regularisation);
    void solve(double regularisation);
    std::vector<int> free_;
    std::vector<double> matrix_, factor_, right_, x_, residual_;
};

}  // namespace serpenoid
