// The steps of free_chain.hpp.
#include "lab/free_chain.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace serpenoid {

FreeChain::FreeChain(const Robot& robot, std::vector<LabLink> links)
    : LabChain(robot, std::move(links), 3, 0),
      angle_(n_ - 1),
      rate_(n_ - 1),
      aim_(n_ - 1),
      links_angle_(n_),
      links_rate_(n_),
      ones_(n_, 1.0) {
    restart();
}

void FreeChain::place(double x, double y, double theta, double vx, double vy, double w) {
    x_ = x, y_ = y, theta_ = theta, u_ = {vx, vy, w}, heat_ = 0;
    restart();
}

void FreeChain::set_joints(const std::vector<double>& angle) {
    angle_ = aim_ = angle;
    restart();
}

void FreeChain::aim(const std::vector<double>& angle, double rate) {
    aim_ = angle, most_rate_ = rate;
}

// The chain as it stands, its joints at rest; no wheel is known to stick.
void FreeChain::restart() {
    std::fill(rate_.begin(), rate_.end(), 0.0);
    shape(theta_);
    for (Contact& wheel : contact_) wheel.impulse = 0;
    settle();
}

// The wheels' rows with link 1 at this angle, inertia, and the momentum of the joints' motion.
void FreeChain::shape(double theta) {
    links_angle_[0] = theta;
    for (int i = 0; i + 1 < n_; ++i) {
        links_angle_[i + 1] = links_angle_[i] + angle_[i];
        links_rate_[i + 1] = links_rate_[i] + rate_[i];
    }
    point(links_angle_);
    J_ = n_ * robot_.I, K_ = 0;
    const std::vector<double>& whole = turning(ones_);
    for (int k = 0; k < 2 * n_; ++k) contact_[k].row[2] = whole[k];
    const std::vector<double>& bending = turning(links_rate_);
    for (int k = 0; k < 2 * n_; ++k) {
        Contact& wheel = contact_[k];
        const std::vector<double>& g = wheel.row;
        J_ += robot_.m * g[2] * g[2], K_ += robot_.m * g[2] * bending[k];
        wheel.offset = bending[k] - g[0] * ground_x_ - g[1] * ground_y_;
    }
    for (const double rate : links_rate_) K_ += robot_.I * rate;
}

bool FreeChain::step(double h) {
    const double momentum = J_ * u_[2] + K_, whole = n_ * robot_.m;
    for (int i = 0; i + 1 < n_; ++i) {
        const double by = std::clamp(aim_[i] - angle_[i], -most_rate_ * h, most_rate_ * h);
        angle_[i] += by, rate_[i] = by / h;
    }
    shape(theta_ + h * u_[2]);
    mass_ = {whole, 0, 0, 0, whole, 0, 0, 0, J_};
    right_ = {whole * (u_[0] + h * slope_.gx), whole * (u_[1] + h * slope_.gy), momentum - K_};
    if (guided_) {
        // a link goes along the rails alone, whatever stiff rails would still give way
        for (Contact& wheel : contact_) wheel.row[1] = wheel.row[2] = 0;
        right_[1] = right_[2] = 0;
    }
    resist(h);
    if (!sweep()) return false;
    x_ += h * u_[0], y_ += h * u_[1], theta_ += h * u_[2];
    return true;
}

bool FreeChain::advance(double duration, double h) {
    const int steps = std::max(1, static_cast<int>(std::ceil(duration / h - 1e-9)));
    for (int k = 0; k < steps; ++k)
        if (!step(duration / steps)) return false;
    return true;
}

bool FreeChain::lead(const std::vector<double>& angle, double duration, double h) {
    double most = 0;
    for (std::size_t i = 0; i < angle.size(); ++i)
        most = std::max(most, std::fabs(angle[i] - angle_[i]));
    // Each joint at its own rate: all arrive together.
    const std::vector<double> from = angle_;
    const int steps = std::max(1, static_cast<int>(std::ceil(duration / h - 1e-9)));
    std::vector<double> next(angle.size());
    for (int k = 1; k <= steps; ++k) {
        for (std::size_t i = 0; i < angle.size(); ++i)
            next[i] = from[i] + (angle[i] - from[i]) * k / steps;
        aim(next, (most + 1) / duration * steps);
        if (!step(duration / steps)) return false;
    }
    return true;
}

double FreeChain::kinetic() const {
    std::vector<double> rate = links_rate_;
    for (double& r : rate) r += u_[2];
    return LabChain::kinetic(rate);
}

std::vector<double> FreeChain::places() {
    std::vector<double> links;
    shape(theta_);
    const std::vector<double>& turn = turning(ones_);  // x is vy, y is -vx
    for (int i = 0; i < n_; ++i) {
        const double t = turn[2 * i], n = turn[2 * i + 1];
        links.push_back(x_ + s_[i] * t + c_[i] * n);
        links.push_back(y_ - c_[i] * t + s_[i] * n);
        links.push_back(links_angle_[i]);
    }
    return links;
}

}  // namespace serpenoid
