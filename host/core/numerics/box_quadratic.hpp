// Minimum of a convex quadratic over a box: forces that hold a body at rest, each within its bound.
//
//     minimise  1/2 z.A z + b.z  over |z_i| <= 1,     A symmetric, positive semidefinite.
//
// A is singular when more contacts hold than are needed. The smallest solution is then taken, which
// spreads the load. Active-set method: some z are fixed at their bounds. Move towards the minimum
// over the others as far as the box allows; a z that reaches its bound is fixed. At the minimum,
// free the bound with the largest inward gradient. The value falls at every move.
#pragma once

#include <vector>

namespace serpenoid {

class BoxQuadratic {
  public:
    // A by rows; z is where to start, and then the minimum. False when rounding makes it cycle.
    bool minimise(const std::vector<double>& A, const std::vector<double>& b,
                  std::vector<double>& z);

    // The smallest z of those that minimise without any bounds.
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
