// The active-set method of kinked_quadratic.hpp.
#include "numerics/kinked_quadratic.hpp"

#include "numerics/cholesky.hpp"

namespace serpenoid {

bool KinkedQuadratic3::factor(const Mat3& H) {
    factor_ = H;
    cholesky(factor_.data(), 3);
    return std::isfinite(factor_[8]);
}

Vec3 KinkedQuadratic3::apply_inverse(Vec3 x) const {
    forward(factor_.data(), 3, x.data());
    backward(factor_.data(), 3, x.data());
    return x;
}

// Minimum over the subspace of held kinks with the present signs, and the held kinks' multipliers:
// H w + sum_free mu s g + G^T nu = b,  G w + e = 0. False when the held rows are dependent.
bool KinkedQuadratic3::target(const Vec3& b, const std::vector<Kink>& kinks, Vec3& w) {
    Vec3 r = b;
    for (std::size_t c = 0; c < kinks.size(); ++c)
        if (!holds(static_cast<int>(c)))
            for (int i = 0; i < 3; ++i) r[i] -= kinks[c].mu * sign_[c] * kinks[c].g[i];
    w = apply_inverse(r);
    if (count_ == 0) return true;
    Vec3 column[3];
    double S[9]{}, nu[3]{};
    for (int a = 0; a < count_; ++a) column[a] = apply_inverse(kinks[set_[a]].g);
    for (int a = 0; a < count_; ++a) {
        const Vec3& g = kinks[set_[a]].g;
        for (int k = 0; k < count_; ++k)
            S[a * count_ + k] = g[0] * column[k][0] + g[1] * column[k][1] + g[2] * column[k][2];
        nu[a] = kinks[set_[a]].value(w);
    }
    // Independent rows only: compare the determinant with the product of the diagonal.
    double ratio = 1;
    for (int a = 0; a < count_; ++a) ratio *= S[a * count_ + a];
    cholesky(S, count_);
    for (int a = 0; a < count_; ++a) ratio *= S[a * count_ + a] * S[a * count_ + a];
    if (!(ratio < 1e13)) return false;
    forward(S, count_, nu);
    backward(S, count_, nu);
    for (int a = 0; a < count_; ++a) {
        multiplier_[a] = nu[a];
        for (int i = 0; i < 3; ++i) w[i] -= nu[a] * column[a][i];
    }
    return true;
}

// Go from w_ along p to the minimum of the whole function on the line. Returns the kink that stops
// the move, or -1; `turned` tells whether kinks were crossed on the way (their signs are changed).
int KinkedQuadratic3::line_search(const Mat3& H, const Vec3& p, const std::vector<Kink>& kinks,
                                  bool& turned) {
    const Vec3 Hp = multiply(H, p);
    const double curvature = p[0] * Hp[0] + p[1] * Hp[1] + p[2] * Hp[2];
    turned = false;
    breaks_.clear();
    for (std::size_t c = 0; c < kinks.size(); ++c) {
        if (holds(static_cast<int>(c))) continue;
        const Kink& k = kinks[c];
        const double rate = k.g[0] * p[0] + k.g[1] * p[1] + k.g[2] * p[2];
        if (rate * sign_[c] >= 0) continue;  // moving away from its kink
        const double t = std::max(0.0, -k.value(w_) / rate);
        if (t < 1) breaks_.push_back({t, 2 * k.mu * std::fabs(rate), static_cast<int>(c)});
    }
    std::sort(breaks_.begin(), breaks_.end(), [](const Break& a, const Break& b) {
        return a.t < b.t || (a.t == b.t && a.kink < b.kink);
    });
    double slope0 = -curvature, t = 1;  // slope at t is slope0 + t curvature, zero at t = 1
    int stop = -1;
    for (const Break& k : breaks_) {
        const double slope = slope0 + k.t * curvature;
        if (slope >= 0) break;
        if (slope + k.jump >= 0) {
            t = k.t;
            stop = k.kink;
            break;
        }
        sign_[k.kink] = -sign_[k.kink];
        slope0 += k.jump;
        turned = true;
    }
    if (stop < 0 && curvature > 0) t = std::min(1.0, -slope0 / curvature);
    for (int i = 0; i < 3; ++i) w_[i] += t * p[i];
    return stop;
}

// Release the held kink whose multiplier exceeds its bound most; false when none does.
bool KinkedQuadratic3::release(const std::vector<Kink>& kinks) {
    int worst = -1;
    double limit = 1 + 1e-12;
    for (int a = 0; a < count_; ++a) {
        const double pull = std::fabs(multiplier_[a]) / kinks[set_[a]].mu;
        if (pull > limit) {
            limit = pull;
            worst = a;
        }
    }
    if (worst < 0) return false;
    sign_[set_[worst]] = multiplier_[worst] > 0 ? 1 : -1;
    set_[worst] = set_[--count_];
    return true;
}

// The minimum with the sets of the last call; true when it solves the whole problem.
bool KinkedQuadratic3::warm_start(const Vec3& b, const std::vector<Kink>& kinks) {
    if (sign_.size() != kinks.size()) {
        sign_.assign(kinks.size(), 1.0);
        count_ = 0;
    }
    for (double& s : sign_) s = s < 0 ? -1 : 1;
    if (!target(b, kinks, w_)) {
        count_ = 0;
        target(b, kinks, w_);
    }
    bool right = true;
    for (std::size_t c = 0; c < kinks.size(); ++c) {
        if (holds(static_cast<int>(c))) continue;
        if (kinks[c].value(w_) * sign_[c] < 0) {
            sign_[c] = -sign_[c];
            right = false;
        }
    }
    for (int a = 0; a < count_; ++a)
        right = right && std::fabs(multiplier_[a]) <= kinks[set_[a]].mu * (1 + 1e-12);
    return right;
}

bool KinkedQuadratic3::solve(const Mat3& H, const Vec3& b, const std::vector<Kink>& kinks) {
    if (!factor(H)) return false;
    bool done = warm_start(b, kinks);
    const int limit = 50 + 20 * static_cast<int>(kinks.size());
    for (int i = 0; !done && i < limit; ++i) {
        Vec3 goal, p;
        if (!target(b, kinks, goal)) {  // a dependent row joined by rounding: let the newest go
            --count_;
            continue;
        }
        bool turned = false;
        int stop = -1;
        if (count_ < 3) {
            for (int k = 0; k < 3; ++k) p[k] = goal[k] - w_[k];
            stop = line_search(H, p, kinks, turned);
        } else {
            w_ = goal;
        }
        if (stop >= 0)
            set_[count_++] = stop;
        else if (!turned)
            done = !release(kinks);
    }
    for (int a = 0; a < count_; ++a)
        sign_[set_[a]] = std::clamp(multiplier_[a] / kinks[set_[a]].mu, -1.0, 1.0);
    return done;
}

}  // namespace serpenoid
