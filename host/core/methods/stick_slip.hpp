// Nonsmooth method of order 2 for the implicit model: every wheel sticks exactly.
//
// Each link of that model is a separate body, so the speed v of a wheel along or across its link
// obeys a scalar equation  v' = g - kappa v - mu sgn v,  kappa = c/m, mu = F0/m (a ratchet has
// other values backwards). g is the acceleration without friction, including the turning of the
// direction. With a constant g over a step this has an exact solution, including rest and reversal:
// a wheel at rest stays at rest while -mu <= g <= mu.
//
// A plain step has order 1. First, springs, dampers and drives change the rates. Then the new rates
// change the angles, friction changes the speeds along the directions at the end of the step, and
// the new velocities change the positions.
//
// A step of the method extrapolates two plain steps of length h/2 and one of length h: 2 y(h/2) -
// y(h), for velocities along and across the links, so that a wheel that rests in both rests
// exactly. If they disagree whether a wheel rests, or in its direction, the result of the half
// steps is taken; this error of h^2 occurs in the few steps in which a wheel changes its mode.
//
// The system has no friction, so the heat in its energy ledger is added here: the impulse of
// friction over a plain step times the mean speed.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "methods/fixed_step.hpp"
#include "model/friction_law.hpp"
#include "model/params.hpp"
#include "scene/system.hpp"

namespace serpenoid {

// The exact solution for one direction, along or across, of all wheels over a step of h seconds.
class Slide {
  public:
    struct Friction {
        double kappa, mu, decay_time;  // 1/s, m/s^2, s
    };

    Slide(const WheelLaw& law, double m, double h)
        : h_(h), forward_(friction_of(law, 1, m)), backward_(friction_of(law, -1, m)) {}

    // The speed at the end of the step, from the speed v at its start.
    double operator()(double v, double g) const {
        double time = h_;
        if (v != 0) {
            const Friction& side = side_of(v);
            const double speed = std::fabs(v), brake = side.mu - std::copysign(1.0, v) * g;
            const double end = speed - (side.kappa * speed + brake) * side.decay_time;
            if (end >= 0) return std::copysign(end, v);
            time -= side.kappa > 0 ? std::log1p(side.kappa * speed / brake) / side.kappa
                                   : speed / brake;
        }
        const Friction& side = side_of(g);
        if (std::fabs(g) <= side.mu) return 0;
        return (g - std::copysign(side.mu, g)) * decay_time(side.kappa, time);
    }

    // The speed from those after two half steps and after a single step.
    double extrapolate(double halves, double single) const {
        const double extrapolated = 2 * halves - single;
        const bool same = halves * single > 0 && halves * extrapolated > 0;
        return (forward_.mu == 0 && backward_.mu == 0) || same ? extrapolated : halves;
    }

    // Acceleration by friction at speed v; at rest friction balances g up to its bound.
    double friction(double v, double g, bool rests) const {
        if (rests) return -std::clamp(g, -backward_.mu, forward_.mu);
        const Friction& side = side_of(v);
        return -(side.kappa * v + std::copysign(side.mu, v));
    }

  private:
    const Friction& side_of(double v) const { return v < 0 ? backward_ : forward_; }
    Friction friction_of(const WheelLaw& law, double direction, double m) const {
        const double kappa = law.viscous(direction) / m;
        return {kappa, law.dry(direction) / m, decay_time(kappa, h_)};
    }
    // The integral of exp(-kappa t) from 0 to t.
    static double decay_time(double kappa, double t) {
        return kappa > 0 ? -std::expm1(-kappa * t) / kappa : t;
    }
    double h_;
    Friction forward_, backward_;
};

// The method; its system is an implicit one without friction, whose state begins with the centres.
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
          start_chain_(robot.n) {}

    void add_friction(System& system) override {
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
        plain_step(t, dt, single_.data(), single_speed_);
        plain_step(t, dt / 2, y, halves_speed_);
        plain_step(t + dt / 2, dt / 2, y, halves_speed_);
        for (std::size_t i = 0; i < single_.size(); ++i) y[i] = 2 * y[i] - single_[i];
        if (!ground_.dry()) return;  // no wheel rests, and this extrapolation conserves momentum
        system_.fill_chain(t + dt, y);
        Chain& k = system_.chain();
        const Slide along_slide = along(dt), across_slide = across(dt);
        for (int i = 0; i < robot_.n; ++i)
            set_velocity(
                k, i, along_slide.extrapolate(halves_speed_[2 * i], single_speed_[2 * i]),
                across_slide.extrapolate(halves_speed_[2 * i + 1], single_speed_[2 * i + 1]));
        write_chain(y);
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
    // Write the state of the chain, and keep the integrals that follow it in y.
    void write_chain(double* y) {
        const int motion_size = 2 * system_.coordinates();
        const std::vector<double> integrals(y + motion_size, y + system_.dim());
        system_.write_state(system_.chain(), y);
        std::copy(integrals.begin(), integrals.end(), y + motion_size);
    }

    void plain_step(double t, double h, double* y, std::vector<double>& speed) {
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
        start_chain_ = k;
        system_.fill_chain(t + h, y);  // the directions at the end of the step
        double heat = 0;
        const auto slow_down = [&](const Slide& slide, double& v, double frictionless) {
            const double old_speed = v;
            v = slide(old_speed, (frictionless - old_speed) / h);
            heat += robot_.m * (frictionless - v) * (old_speed + v) / 2;
        };
        for (int i = 0; i < n; ++i) {
            double &vt = speed[2 * i], &vn = speed[2 * i + 1];
            k.vx[i] = start_chain_.vx[i] + h * start_chain_.ax[i];
            k.vy[i] = start_chain_.vy[i] + h * start_chain_.ay[i];
            slow_down(along_slide, vt, speed_t(k, i));
            slow_down(across_slide, vn, speed_n(k, i));
            set_velocity(k, i, vt, vn);
            k.x[i] = start_chain_.x[i] + h * k.vx[i];
            k.y[i] = start_chain_.y[i] + h * k.vy[i];
        }
        write_chain(y);
        if (system_.ledger()) y[2 * m + EnergyLedger::kHeat] += heat;
    }

    Robot robot_;
    Ground ground_;
    std::vector<double> dy_, single_, single_speed_, halves_speed_;
    Chain start_chain_;  // the chain at the start of a plain step
};

}  // namespace serpenoid
