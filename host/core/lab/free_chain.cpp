// The steps of free_chain.hpp.
#include "lab/free_chain.hpp"

#include <algorithm>
#include <cmath>

namespace serpenoid {

namespace {
constexpr double kRest = 1e-9;   // m/s: a wheel that held has less, by rounding
constexpr double kFlat = 1e-12;  // a wheel square to the rails: no motion along them turns it
}  // namespace

FreeChain::FreeChain(const Robot& robot, std::vector<LabLink> links)
    : robot_(robot),
      links_(std::move(links)),
      angle_(robot.n - 1),
      rate_(robot.n - 1),
      aim_(robot.n - 1),
      spin_(robot.n),
      skid_(robot.n),
      part_(robot.n),
      along_(robot.n),
      across_(robot.n) {
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
    shape();
    rows(theta_);
    for (int i = 0; i < robot_.n; ++i) spin_[i] = along_[i].at(u_), skid_[i] = across_[i].at(u_);
    convex_.forget();
}

void FreeChain::shape() {
    const double l = robot_.l;
    double a = 0, w = 0, x = 0, y = 0, dx = 0, dy = 0, mx = 0, my = 0, mdx = 0, mdy = 0;
    for (int i = 0; i < robot_.n; ++i) {
        Part& p = part_[i];
        if (i > 0) {
            x += l * part_[i - 1].c, y += l * part_[i - 1].s;
            dx -= l * w * part_[i - 1].s, dy += l * w * part_[i - 1].c;
            a += angle_[i - 1], w += rate_[i - 1];
        }
        p.c = std::cos(a), p.s = std::sin(a), p.w = w;
        if (i > 0) x += l * p.c, y += l * p.s, dx -= l * w * p.s, dy += l * w * p.c;
        p.rx = x, p.ry = y, p.dx = dx, p.dy = dy;
        mx += x, my += y, mdx += dx, mdy += dy;
    }
    const double f = 1.0 / robot_.n;
    J_ = robot_.n * robot_.I, K_ = 0;
    for (Part& p : part_) {
        p.rx -= f * mx, p.ry -= f * my, p.dx -= f * mdx, p.dy -= f * mdy;
        J_ += robot_.m * (p.rx * p.rx + p.ry * p.ry);
        K_ += robot_.I * p.w + robot_.m * (p.rx * p.dy - p.ry * p.dx);
    }
}

// Speeds of all links over the ground as rows of u, link 1 at this angle.
void FreeChain::rows(double theta) {
    const double c = std::cos(theta), s = std::sin(theta);
    for (int i = 0; i < robot_.n; ++i) {
        const Part& p = part_[i];
        const double tx = c * p.c - s * p.s, ty = s * p.c + c * p.s;
        const double rx = c * p.rx - s * p.ry, ry = s * p.rx + c * p.ry;
        const double ex = c * p.dx - s * p.dy - ground_x_, ey = s * p.dx + c * p.dy - ground_y_;
        along_[i] = {{tx, ty, rx * ty - ry * tx}, tx * ex + ty * ey};
        across_[i] = {{-ty, tx, rx * tx + ry * ty}, tx * ey - ty * ex};
        // between rails a link goes along them alone, whatever stiff rails would still give way
        if (guided_) along_[i].g = {tx, 0, 0}, across_[i].g = {-ty, 0, 0};
    }
}

bool FreeChain::move_joints(double h) {
    bool changed = false;
    for (std::size_t i = 0; i < angle_.size(); ++i) {
        const double most = most_rate_ * h;
        const double by = std::clamp(aim_[i] - angle_[i], -most, most);
        changed = changed || by != 0 || rate_[i] != 0;
        angle_[i] += by, rate_[i] = by / h;
    }
    return changed;
}

bool FreeChain::step(double h) {
    const double momentum = J_ * u_[2] + K_;
    if (move_joints(h)) shape();
    rows(theta_ + h * u_[2]);
    const double nm = robot_.n * robot_.m;
    Mat3 H = {nm, 0, 0, 0, nm, 0, 0, 0, J_};
    Vec3 b = {nm * (u_[0] + h * slope_.gx), nm * (u_[1] + h * slope_.gy), momentum - K_};
    const auto add = [&](const Row& row, double weight, double offset) {
        for (int i = 0; i < 3; ++i) {
            for (int j = 0; j < 3; ++j) H[3 * i + j] += weight * row.g[i] * row.g[j];
            b[i] -= offset * row.g[i];
        }
    };
    kinks_.clear();
    // A straight chain's six kinks meet in one point, where the active-set method could cycle.
    // Moved by squares of their number no three of them meet (by the number itself they all would).
    const auto kink = [&](const Row& row, double dry, double before, const LabLink& link) {
        if (!(dry > 0) || (guided_ && std::fabs(row.g[0]) < kFlat)) return;
        const bool rested = std::fabs(before) < kRest;
        const auto c = static_cast<double>(kinks_.size() + 1);
        const double apart = 1e-11 * std::fmod(0.6180339887 * c * c, 1.0);
        kinks_.push_back({row.g, row.e + apart, h * dry * (rested ? link.breakaway : 1)});
    };
    for (int i = 0; i < robot_.n; ++i) {
        const LabLink& k = links_[i];
        const WheelLaw t = WheelLaw::along(k.ground), n = WheelLaw::across(k.ground);
        const double ct = t.viscous(spin_[i]);
        add(along_[i], h * ct + k.rolling,
            (h * ct + k.rolling) * along_[i].e - k.rolling * spin_[i] - h * t.thrust);
        add(across_[i], h * n.viscous(0), h * n.viscous(0) * across_[i].e);
        kink(along_[i], t.bound, spin_[i], k);
        kink(across_[i], n.bound, skid_[i], k);
    }
    if (guided_) H[4] = H[8] = 1, b[1] = b[2] = 0;  // no row acts on them
    if (!convex_.solve(H, b, kinks_)) return false;
    u_ = convex_.minimum();
    x_ += h * u_[0], y_ += h * u_[1], theta_ += h * u_[2];
    for (int i = 0; i < robot_.n; ++i) {
        const Ground& k = links_[i].ground;
        const double t = spin_[i] = along_[i].at(u_), n = skid_[i] = across_[i].at(u_);
        heat_ += h * (WheelLaw::along(k).dissipation(t) + WheelLaw::across(k).dissipation(n));
    }
    return std::isfinite(x_ + y_ + theta_);
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
    double sum = robot_.n * robot_.m * (u_[0] * u_[0] + u_[1] * u_[1]);
    for (int i = 0; i < robot_.n; ++i) {
        const Part& p = part_[i];
        const double w = u_[2] + p.w, x = p.dx - u_[2] * p.ry, y = p.dy + u_[2] * p.rx;
        sum +=
            robot_.I * w * w + robot_.m * (x * x + y * y) + links_[i].rolling * spin_[i] * spin_[i];
    }
    return 0.5 * sum;
}

std::vector<double> FreeChain::places() const {
    std::vector<double> found;
    const double c = std::cos(theta_), s = std::sin(theta_);
    for (const Part& p : part_) {
        found.push_back(x_ + c * p.rx - s * p.ry);
        found.push_back(y_ + s * p.rx + c * p.ry);
        found.push_back(theta_ + std::atan2(p.s, p.c));
    }
    return found;
}

}  // namespace serpenoid
