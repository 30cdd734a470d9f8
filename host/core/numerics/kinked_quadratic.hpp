// Exact minimum of a convex function of three unknowns: a quadratic plus weighted absolute values.
//
//     minimise  1/2 w.H w - b.w + sum_c mu_c |g_c . w + e_c|,     H symmetric positive definite.
//
// One implicit step of a chain on dry ground is this problem (w: the velocities, c: the wheels'
// directions, mu_c: the dry friction times the step). A kink with g_c.w + e_c = 0 at the minimum is
// a wheel that sticks. Active-set method: with a set of kinks held (at most three, independent) and
// a sign for every other one, the minimum is a linear system; an exact search along the line to it
// stops at the first kink that bends the slope upwards, which joins the set; a held kink whose
// multiplier leaves [-mu, mu] is let go. The value falls at every move, so it ends after finitely
// many; signs and set are kept between calls, and one linear solve is then the usual cost.
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
    // Solve from the sets of the last call. Returns false only when rounding makes it cycle.
    bool solve(const Mat3& H, const Vec3& b, const std::vector<Kink>& kinks);

    const Vec3& minimum() const { return w_; }
    // Multiplier over mu, in [-1, 1]: minus the dry force in units of its bound; sign where
    // sliding.
    double sign(int c) const { return sign_[c]; }
    bool holds(int c) const { return std::find(set_, set_ + count_, c) != set_ + count_; }
    void forget() {
        sign_.clear();
        count_ = 0;
    }

  private:
    struct Break {
        double t, jump;
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
    Mat3 factor_{};  // of H
    std::vector<Break> breaks_;
};

}  // namespace serpenoid
