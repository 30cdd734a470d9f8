// Nonsmooth steps of the implicit model: exact sticking, wheel by wheel, order 2.
//
// Each link of that model is a body of its own, so the speed v of a wheel along or across it has a
// scalar equation  v' = g - kappa v - mu sgn v,  kappa = c/m, mu = F0/m (along a ratchet other ones
// backwards), where g is all that is not friction (the turning of the direction itself included).
// With g held over a step it is solved exactly, rest and reversal too: a wheel at rest stays there
// while -mu <= g <= mu. A plain step, of order 1: springs, dampers and drives kick the rates;
// angles move with the new ones; wheels slide along the directions at the end; places follow.
//
// A step of the method is two plain ones of half its length and a whole one, extrapolated:
// 2 y(h/2) - y(h), velocities along and across the links, where what rests in both rests exactly.
// Where they disagree whether a wheel rests, or which way it goes, the halves count (an error of
// h^2, in the few steps in which a wheel changes its mode).
//
// An energy ledger behind the state knows a system without friction: its heat is booked here, the
// impulse of friction over a plain step times the mean speed.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "methods/fixed_step.hpp"
#include "model/friction_law.hpp"
#include "model/params.hpp"
#include "scene/system.hpp"

namespace serpenoid {

// One direction of all wheels over a step of h seconds; the friction may differ by the way they go.
class Slide {
  public:
    struct Friction {
        double kappa, mu, reach;
    };

    Slide(const WheelLaw& law, double m, double h)
        : h_(h), forward_(friction_of(law, 1, m)), backward_(friction_of(law, -1, m)) {}

    // Speed at the end from that at the start.
    double operator()(double v, double g) const {
        double time = h_;
        if (v != 0) {
            const Friction& w = going(v);
            const double speed = std::fabs(v), brake = w.mu - std::copysign(1.0, v) * g;
            const double end = speed - (w.kappa * speed + brake) * w.reach;
            if (end >= 0) return std::copysign(end, v);
            time -= w.kappa > 0 ? std::log1p(w.kappa * speed / brake) / w.kappa : speed / brake;
        }
        const Friction& w = going(g);
        if (std::fabs(g) <= w.mu) return 0;
        return (g - std::copysign(w.mu, g)) * reach(w.kappa, time);
    }

    // A step from its two halves' result and the whole one's.
    double extrapolate(double halves, double single) const {
        const double extrapolated = 2 * halves - single;
        const bool same = halves * single > 0 && halves * extrapolated > 0;
        return (forward_.mu == 0 && backward_.mu == 0) || same ? extrapolated : halves;
    }

    // Acceleration by friction at a speed; a wheel at rest takes g up as far as it can.
    double friction(double v, double g, bool rests) const {
        if (rests) return -std::clamp(g, -backward_.mu, forward_.mu);
        const Friction& w = going(v);
        return -(w.kappa * v + std::copysign(w.mu, v));
    }

  private:
    const Friction& going(double v) const { return v < 0 ? backward_ : forward_; }
    Friction friction_of(const WheelLaw& law, double direction, double m) const {
        const double kappa = law.viscous(direction) / m;
        return {kappa, law.dry(direction) / m, reach(kappa, h_)};
    }
    static double reach(double kappa, double t) {
        return kappa > 0 ? -std::expm1(-kappa * t) / kappa : t;
    }
    double h_;
    Friction forward_, backward_;
};

// The system is an implicit one without friction; its state starts with the centres.
class StickSlip : public FixedStep {
  public:
    StickSlip(System& frictionless, const Robot& robot, const Ground& ground, double dt)
        : FixedStep(frictionless, dt),
          robot_(robot),
          ground_(ground),
          dy_(frictionless.dim()),
          single_(frictionless.dim()),
          single_speed_(2 * robot.n),
          halves_speed_(2 * robot.n),
          centre_(robot.n) {}

    void give_forces(System& system) override {
        Chain& k = system.chain();
        double fastest = 0;
        for (int i = 0; i < robot_.n; ++i)
            fastest = std::max(fastest, std::fabs(k.vx[i]) + std::fabs(k.vy[i]));
        const double rounding = 1e-14 * fastest;
        for (int i = 0; i < robot_.n; ++i) {
            const double c = k.c[i], s = k.s[i], w = k.omega[i], m = robot_.m;
            const double vt = c * k.vx[i] + s * k.vy[i], vn = -s * k.vx[i] + c * k.vy[i];
            const double gt = c * k.ax[i] + s * k.ay[i] + w * vn;
            const double gn = -s * k.ax[i] + c * k.ay[i] - w * vt;
            const double ft = m * along(0).friction(vt, gt, std::fabs(vt) <= rounding);
            const double fn = m * across(0).friction(vn, gn, std::fabs(vn) <= rounding);
            k.fx[i] += c * ft - s * fn;
            k.fy[i] += s * ft + c * fn;
        }
    }

  protected:
    void advance(double t, double dt, double* y) override {
        single_.assign(y, y + single_.size());
        plain(t, dt, single_.data(), single_speed_);
        plain(t, dt / 2, y, halves_speed_);
        plain(t + dt / 2, dt / 2, y, halves_speed_);
        for (std::size_t i = 0; i < single_.size(); ++i) y[i] = 2 * y[i] - single_[i];
        if (!ground_.dry()) return;  // nothing rests, and momentum is kept as the frame keeps it
        system_.fill(t + dt, y);
        Chain& k = system_.chain();
        const Slide along_slide = along(dt), across_slide = across(dt);
        for (int i = 0; i < robot_.n; ++i)
            set_velocity(
                k, i, along_slide.extrapolate(halves_speed_[2 * i], single_speed_[2 * i]),
                across_slide.extrapolate(halves_speed_[2 * i + 1], single_speed_[2 * i + 1]));
        set_centres(y);
    }

  private:
    Slide along(double h) const { return {ground_.along, robot_.m, h}; }
    Slide across(double h) const { return {ground_.across, robot_.m, h}; }

    // Speeds of wheel i along and across its link.
    static double speed_t(const Chain& k, int i) { return k.c[i] * k.vx[i] + k.s[i] * k.vy[i]; }
    static double speed_n(const Chain& k, int i) { return k.c[i] * k.vy[i] - k.s[i] * k.vx[i]; }
    static void set_velocity(Chain& k, int i, double vt, double vn) {
        k.vx[i] = k.c[i] * vt - k.s[i] * vn;
        k.vy[i] = k.s[i] * vt + k.c[i] * vn;
    }
    // The state of the chain; what is integrated beside it stays.
    void set_centres(double* y) {
        const int beside = 2 * system_.coordinates();
        const std::vector<double> integrals(y + beside, y + system_.dim());
        system_.set(system_.chain(), y);
        std::copy(integrals.begin(), integrals.end(), y + beside);
    }

    void plain(double t, double h, double* y, std::vector<double>& speed) {
        const int n = robot_.n, m = system_.coordinates();
        const Slide along_slide = along(h), across_slide = across(h);
        Chain& k = system_.chain();
        system_.rate(t, y, dy_.data());
        for (int i = 0; i < n; ++i) {
            speed[2 * i] = speed_t(k, i);
            speed[2 * i + 1] = speed_n(k, i);
        }
        for (std::size_t i = m; i < dy_.size(); ++i) y[i] += h * dy_[i];
        for (int i = system_.lengths(); i < m; ++i) y[i] += h * y[m + i];
        centre_ = k;
        system_.fill(t + h, y);  // the directions at the end of the step
        double heat = 0;
        const auto slide = [&](const Slide& slide_by, double& v, double kicked) {
            const double old_speed = v;
            v = slide_by(old_speed, (kicked - old_speed) / h);
            heat += robot_.m * (kicked - v) * (old_speed + v) / 2;
        };
        for (int i = 0; i < n; ++i) {
            double &vt = speed[2 * i], &vn = speed[2 * i + 1];
            k.vx[i] = centre_.vx[i] + h * centre_.ax[i];
            k.vy[i] = centre_.vy[i] + h * centre_.ay[i];
            slide(along_slide, vt, speed_t(k, i));
            slide(across_slide, vn, speed_n(k, i));
            set_velocity(k, i, vt, vn);
            k.x[i] = centre_.x[i] + h * k.vx[i];
            k.y[i] = centre_.y[i] + h * k.vy[i];
        }
        set_centres(y);
        if (system_.ledger()) y[2 * m + EnergyLedger::kHeat] += heat;
    }

    Robot robot_;
    Ground ground_;
    std::vector<double> dy_, single_, single_speed_, halves_speed_;
    Chain centre_;  // at the start of a plain step
};

}  // namespace serpenoid
