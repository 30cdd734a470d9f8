// Contacts and wheels of lab_chain.hpp.
#include "lab/lab_chain.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "numerics/cholesky.hpp"

namespace serpenoid {

namespace {

constexpr double kAtRest = 1e-5;     // m/s: a wheel that held has less
constexpr double kNoChange = 1e-20;  // J: of an impulse times the speed that it changes
constexpr double kUnmoved = 1e-24;   // 1/kg: an impulse that moves nothing
constexpr int kMostSweeps = 3000;

// The friction of a wheel in one direction: c |v| + F0 against the motion, with other numbers
// backwards on a ratchet. At rest it is what holds the wheel, up to F0 times the breakaway.
struct Friction {
    double viscous, dry, viscous_back, dry_back;
};

Friction along(const Ground& g) { return {g.ct, g.ft0, g.ct_back, g.ft0_back}; }
Friction across(const Ground& g) { return {g.cn, g.fn0, g.cn, g.fn0}; }

}  // namespace

LabChain::LabChain(const Robot& robot, std::vector<LabLink> links, int size, int others)
    : robot_(robot),
      links_(std::move(links)),
      n_(robot.n),
      size_(size),
      vx_(n_),
      vy_(n_),
      u_(size),
      mass_(size * size),
      right_(size),
      c_(n_),
      s_(n_),
      speeds_(2 * n_),
      contact_(2 * n_ + others) {
    for (Contact& c : contact_) c.row.assign(size, 0.0);
}

void LabChain::point(const std::vector<double>& angle) {
    for (int i = 0; i < n_; ++i) {
        const double c = c_[i] = std::cos(angle[i]), s = s_[i] = std::sin(angle[i]);
        double *t = contact_[2 * i].row.data(), *n = contact_[2 * i + 1].row.data();
        t[0] = c, t[1] = s, n[0] = -s, n[1] = c;
    }
}

const std::vector<double>& LabChain::turning(const std::vector<double>& rate) {
    double mean_x = 0, mean_y = 0;
    for (const bool total : {true, false}) {
        double x = -mean_x, y = -mean_y;
        for (int i = 0; i < n_; ++i) {
            if (i > 0) {
                x -= robot_.l * (rate[i - 1] * s_[i - 1] + rate[i] * s_[i]);
                y += robot_.l * (rate[i - 1] * c_[i - 1] + rate[i] * c_[i]);
            }
            if (total) mean_x += x / n_, mean_y += y / n_;
            speeds_[2 * i] = c_[i] * x + s_[i] * y, speeds_[2 * i + 1] = c_[i] * y - s_[i] * x;
        }
    }
    return speeds_;
}

void LabChain::add_square(const Contact& contact, double weight, double target) {
    const double* row = contact.row.data();
    add(right_.data(), size_, weight * (target - contact.offset), row);
    for (int i = 0; i < size_; ++i)  // the upper triangle
        if (row[i] != 0) add(&mass_[i * size_ + i], size_ - i, weight * row[i], row + i);
}

void LabChain::resist(double h) {
    for (int k = 0; k < 2 * n_; ++k) {
        Contact& wheel = contact_[k];
        const LabLink& link = links_[k / 2];
        const Friction f = k % 2 == 0 ? along(link.ground) : across(link.ground);
        if (k % 2 == 0) add_square(wheel, link.rolling, wheel.before);
        wheel.viscous = h * (wheel.before < 0 ? f.viscous_back : f.viscous);
        add_square(wheel, wheel.viscous, 0);
        const double hold = std::fabs(wheel.before) < kAtRest ? h * link.breakaway : h;
        wheel.least = -hold * f.dry, wheel.most = hold * f.dry_back;
    }
}

bool LabChain::sweep() {
    cholesky(mass_.data(), size_);
    const auto solved = [&](std::vector<double>& x) {
        forward(mass_.data(), size_, x.data()), backward(mass_.data(), size_, x.data());
    };
    u_ = right_, solved(u_);
    for (Contact& c : contact_) {
        c.reach = c.row, solved(c.reach);
        const double gives = dot(c.row.data(), c.reach.data(), size_);
        c.mass = gives > kUnmoved ? 1 / gives : 0;
        c.impulse = std::clamp(c.impulse, c.least, c.most);
        add(u_.data(), size_, c.impulse, c.reach.data());
    }
    bool changed = true;
    for (int look = 0; look < kMostSweeps && changed; ++look) {
        changed = false;
        for (Contact& c : contact_) {
            const double v = c.offset + dot(c.row.data(), u_.data(), size_);
            const double stopping = c.impulse - c.mass * v;
            const double by = std::clamp(stopping, c.least, c.most) - c.impulse;
            if (by == 0) continue;
            c.impulse += by;
            add(u_.data(), size_, by, c.reach.data());
            changed = changed || by * by > kNoChange * c.mass;
        }
    }
    settle();
    for (int k = 0; k < 2 * n_; ++k) {
        const Contact& wheel = contact_[k];
        heat_ += (wheel.viscous * wheel.before - wheel.impulse) * wheel.before;
    }
    return std::isfinite(u_[0] + u_[1] + u_[2]);
}

void LabChain::settle() {
    for (Contact& c : contact_) c.before = c.offset + dot(c.row.data(), u_.data(), size_);
    for (int i = 0; i < n_; ++i) {
        const double t = contact_[2 * i].before, n = contact_[2 * i + 1].before;
        vx_[i] = c_[i] * t - s_[i] * n + ground_x_, vy_[i] = s_[i] * t + c_[i] * n + ground_y_;
    }
}

double LabChain::kinetic(const std::vector<double>& rate) const {
    double sum = 0;
    for (int i = 0; i < n_; ++i) {
        const double spin = contact_[2 * i].before;
        sum += robot_.m * (vx_[i] * vx_[i] + vy_[i] * vy_[i]) + robot_.I * rate[i] * rate[i] +
               links_[i].rolling * spin * spin;
    }
    return 0.5 * sum;
}

}  // namespace serpenoid
