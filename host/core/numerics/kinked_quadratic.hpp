// Exact minimum of a convex function of three unknowns: a quadratic plus weighted absolute values.
//
//     minimise  1/2 w.H w - b.w + sum_c mu_c |g_c . w + e_c|,     H symmetric positive definite.
//
// One implicit step of a chain on dry ground is this problem: w are the velocities, c the wheels'
// directions, mu_c the dry friction times the step. A kink with g_c.w + e_c = 0 at the minimum is a
// wheel that sticks.
//
// Active-set method: with at most three independent kinks in the set, and a sign for every other
// kink, the minimum is the solution of a linear system. An exact line search towards it stops at
// the first kink after which the function rises; this kink joins the set. A kink in the set whose
// multiplier leaves [-mu, mu] is removed. The function falls at every move, so the method ends.
// Signs and set are kept between calls, so that one linear system is mostly enough.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "numerics/dense.hpp"

namespace serpenoid {

struct Kink {
    Vec3 g;
    double e, mu;
    double value(const Vec3& w) const { return g[0] * w[0] + g[1] * w[1] + g[2] * w[2] + e; }
};

class KinkedQuadratic3 {
  public:
    // Solve, starting from the set and signs of the last call. False if rounding makes it cycle.
    bool solve(const Mat3& H, const Vec3& b, const std::vector<Kink>& kinks);

    const Vec3& minimum() const { return w_; }
    // Multiplier over mu, in [-1, 1], which is minus the dry force over its bound; a sliding wheel
    // has -1 or 1.
    double sign(int c) const { return sign_[c]; }
    bool holds(int c) const { return std::find(set_, set_ + count_, c) != set_ + count_; }
    // Discard the set and signs of the last call.
    void forget() {
        sign_.clear();
        count_ = 0;
    }

  private:
    struct Break {       // a kink on the line of the search
        double t, jump;  // position on the line, change of slope
        int kink;
    };
    bool factor(const Mat3& H);
    Vec3 apply_inverse(Vec3 x) const;
    bool target(const Vec3& b, const std::vector<Kink>& kinks, Vec3& w);
    int line_search(const Mat3& H, const Vec3& p, const std::vector<Kink>& kinks, bool& turned);
    bool release(const std::vector<Kink>& kinks);
    bool warm_start(const Vec3& b, const std::vector<Kink>& kinks);

    Vec3 w_{};
    std::vector<double> sign_;
    int set_[3] = {0, 0, 0}, count_ = 0;
    double multiplier_[3] = {0, 0, 0};
    Mat3 factor_{};  // Cholesky factor of H
    std::vector<Break> breaks_;
};

}  // namespace serpenoid
