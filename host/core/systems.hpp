// The four combinations of formulation and drive as first-order systems y' = rate(t, y).
//
// Each keeps its own smallest state and knows how to take it from, and give it back as, a chain.
#pragma once

#include <cmath>
#include <vector>

#include "explicit_model.hpp"
#include "friction_law.hpp"
#include "gait.hpp"
#include "simulation.hpp"

namespace serpenoid {

// What all four share: the request, the gait and scratch memory.
template <class Law>
struct SystemBase {
    explicit SystemBase(const RunRequest& request)
        : q(request),
          n(request.robot.n),
          law(request.ground, request.smoothing),
          gait(request.robot.n, request.gait),
          chain(request.robot.n),
          joints(request.robot.n),
          bend(request.robot.n) {}

    // Angles and rates of all links from those of link 1 (Eq. 57).
    void bend_by_gait(double t, double theta1, double omega1) {
        const double w = q.gait.omega, sin_tau = std::sin(w * t), cos_tau = std::cos(w * t);
        chain.theta[0] = theta1, chain.omega[0] = omega1;
        for (int i = 0; i + 1 < n; ++i) {
            const GaitTable::Joint j = gait.at(i, sin_tau, cos_tau);
            chain.theta[i + 1] = chain.theta[i] + j.angle;
            chain.omega[i + 1] = chain.omega[i] + w * j.rate;
            bend[i] = w * w * j.curvature;
        }
        chain.directions();
    }

    const RunRequest& q;
    int n;
    Law law;
    GaitTable gait;
    Chain chain;
    Joints joints;
    std::vector<double> bend;
};

// State: x, y, theta of link 1, then their rates.
template <class Law>
struct ExplicitAngle : SystemBase<Law> {
    using SystemBase<Law>::SystemBase;
    int dim() const { return 6; }

    void set(const Chain& c, double* y) const {
        const double from[6] = {c.x[0], c.y[0], c.theta[0], c.vx[0], c.vy[0], c.omega[0]};
        for (int i = 0; i < 6; ++i) y[i] = from[i];
    }
    void fill(double t, const double* y) {
        Chain& c = this->chain;
        this->bend_by_gait(t, y[2], y[5]);
        c.x[0] = y[0], c.y[0] = y[1], c.vx[0] = y[3], c.vy[0] = y[4];
        c.follow(this->q.robot.l);
    }
    void rate(double t, const double* y, double* dy) {
        fill(t, y);
        this->chain.friction(this->law);
        explicit_angle(this->q.robot, this->bend.data(), this->chain, this->joints);
        const Chain& c = this->chain;
        const double to[6] = {y[3], y[4], y[5], c.ax[0], c.ay[0], c.alpha[0]};
        for (int i = 0; i < 6; ++i) dy[i] = to[i];
    }
};

// State: x, y of link 1, theta_1..theta_n, then their rates.
template <class Law>
struct ExplicitTorque : SystemBase<Law> {
    using SystemBase<Law>::SystemBase;
    int dim() const { return 2 * (this->n + 2); }

    void set(const Chain& c, double* y) const {
        const int n = this->n;
        y[0] = c.x[0], y[1] = c.y[0], y[n + 2] = c.vx[0], y[n + 3] = c.vy[0];
        for (int i = 0; i < n; ++i) y[2 + i] = c.theta[i], y[n + 4 + i] = c.omega[i];
    }
    void fill(double, const double* y) {
        Chain& c = this->chain;
        const int n = this->n;
        c.x[0] = y[0], c.y[0] = y[1], c.vx[0] = y[n + 2], c.vy[0] = y[n + 3];
        for (int i = 0; i < n; ++i) c.theta[i] = y[2 + i], c.omega[i] = y[n + 4 + i];
        c.directions();
        c.follow(this->q.robot.l);
    }
    void rate(double t, const double* y, double* dy) {
        const int n = this->n;
        fill(t, y);
        this->chain.friction(this->law);
        this->q.torque(t, this->joints.T.data());
        explicit_torque(this->q.robot, this->chain, this->joints);
        for (int i = 0; i < n + 2; ++i) dy[i] = y[n + 2 + i];
        const Chain& c = this->chain;
        dy[n + 2] = c.ax[0], dy[n + 3] = c.ay[0];
        for (int i = 0; i < n; ++i) dy[n + 4 + i] = c.alpha[i];
    }
};

// State: x, y, vx, vy of every link (n values each), then theta and omega of link 1.
template <class Law>
struct ImplicitAngle : SystemBase<Law> {
    using SystemBase<Law>::SystemBase;
    int dim() const { return 4 * this->n + 2; }

    void set(const Chain& c, double* y) const {
        const int n = this->n;
        for (int i = 0; i < n; ++i)
            y[i] = c.x[i], y[n + i] = c.y[i], y[2 * n + i] = c.vx[i], y[3 * n + i] = c.vy[i];
        y[4 * n] = c.theta[0], y[4 * n + 1] = c.omega[0];
    }
    void fill(double t, const double* y) {
        Chain& c = this->chain;
        const int n = this->n;
        for (int i = 0; i < n; ++i)
            c.x[i] = y[i], c.y[i] = y[n + i], c.vx[i] = y[2 * n + i], c.vy[i] = y[3 * n + i];
        this->bend_by_gait(t, y[4 * n], y[4 * n + 1]);
    }
    void rate(double t, const double* y, double* dy) {
        const int n = this->n;
        fill(t, y);
        this->chain.friction(this->law);
        implicit_angle(this->q.robot, this->q.spring, this->bend.data(), this->chain, this->joints);
        const Chain& c = this->chain;
        for (int i = 0; i < n; ++i) {
            dy[i] = c.vx[i], dy[n + i] = c.vy[i];
            dy[2 * n + i] = c.ax[i], dy[3 * n + i] = c.ay[i];
        }
        dy[4 * n] = c.omega[0], dy[4 * n + 1] = c.alpha[0];
    }
};

// State: x, y, theta of every link (n values each), then their rates.
template <class Law>
struct ImplicitTorque : SystemBase<Law> {
    using SystemBase<Law>::SystemBase;
    int dim() const { return 6 * this->n; }

    void set(const Chain& c, double* y) const {
        const int n = this->n;
        const std::vector<double>* part[6] = {&c.x, &c.y, &c.theta, &c.vx, &c.vy, &c.omega};
        for (int p = 0; p < 6; ++p)
            for (int i = 0; i < n; ++i) y[p * n + i] = (*part[p])[i];
    }
    void fill(double, const double* y) {
        const int n = this->n;
        Chain& c = this->chain;
        std::vector<double>* part[6] = {&c.x, &c.y, &c.theta, &c.vx, &c.vy, &c.omega};
        for (int p = 0; p < 6; ++p)
            for (int i = 0; i < n; ++i) (*part[p])[i] = y[p * n + i];
        c.directions();
    }
    void rate(double t, const double* y, double* dy) {
        const int n = this->n;
        fill(t, y);
        this->chain.friction(this->law);
        this->q.torque(t, this->joints.T.data());
        implicit_torque(this->q.robot, this->q.spring, this->chain, this->joints);
        const Chain& c = this->chain;
        for (int i = 0; i < 3 * n; ++i) dy[i] = y[3 * n + i];
        for (int i = 0; i < n; ++i)
            dy[3 * n + i] = c.ax[i], dy[4 * n + i] = c.ay[i], dy[5 * n + i] = c.alpha[i];
    }
};

}  // namespace serpenoid
