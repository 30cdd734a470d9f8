// Runs in time: picks the system and the method once, then steps and records.
#include "simulation.hpp"

#include <algorithm>
#include <cmath>

#include "dry_motion.hpp"
#include "implicit_prox.hpp"
#include "rk4.hpp"
#include "systems.hpp"

namespace serpenoid {

namespace {

Chain start_chain(const RunRequest& q) {
    const int n = q.robot.n;
    Chain c(n);
    std::vector<double>* part[6] = {&c.x, &c.y, &c.theta, &c.vx, &c.vy, &c.omega};
    for (int p = 0; p < 6; ++p) std::copy_n(q.start.begin() + p * n, n, part[p]->begin());
    return c;
}

void append(std::vector<double>& to, const std::vector<double>& row) {
    to.insert(to.end(), row.begin(), row.end());
}

void record(RunResult& out, double t, const Chain& c, const Joints* joints) {
    out.t.push_back(t);
    append(out.x, c.x), append(out.y, c.y), append(out.theta, c.theta);
    append(out.vx, c.vx), append(out.vy, c.vy), append(out.omega, c.omega);
    if (!joints) return;
    append(out.joint_fx, joints->Fx), append(out.joint_fy, joints->Fy);
    append(out.joint_torque, joints->T);
}

bool finite(const std::vector<double>& y) {
    double sum = 0;
    for (const double v : y) sum += v * 0;
    return sum == 0;
}

// Step a system and record it; `advance(t, dt, y)` is the method.
template <class System, class Advance>
RunResult run(const RunRequest& q, System& system, Advance advance) {
    RunResult out;
    std::vector<double> y(system.dim()), rate(system.dim());
    system.set(start_chain(q), y.data());
    const auto note = [&](double t) {
        if (q.record_joints) {
            system.rate(t, y.data(), rate.data());
            record(out, t, system.chain, &system.joints);
        } else {
            system.fill(t, y.data());
            record(out, t, system.chain, nullptr);
        }
    };
    note(0);
    for (long i = 0; i < q.steps; ++i) {
        const double from = static_cast<double>(i) * q.dt;
        const double t = i + 1 == q.steps ? q.duration : from + q.dt;
        advance(from, t - from, y);
        const bool due = (i + 1) % q.every == 0 || i + 1 == q.steps;
        if ((due || i % 64 == 0) && !finite(y)) {
            out.failed_at = t;
            break;
        }
        if (due) note(t);
    }
    return out;
}

template <template <class> class System, class Law>
RunResult run_rk4(const RunRequest& q) {
    System<Law> system(q);
    Rk4 rk4(system.dim());
    const auto rate = [&](double t, const double* y, double* dy) { system.rate(t, y, dy); };
    return run(q, system,
               [&](double t, double dt, std::vector<double>& y) { rk4.step(rate, t, dt, y); });
}

template <class Law>
RunResult run_law(const RunRequest& q) {
    if (q.formulation == Formulation::explicit_)
        return q.drive == Drive::angle ? run_rk4<ExplicitAngle, Law>(q)
                                       : run_rk4<ExplicitTorque, Law>(q);
    return q.drive == Drive::angle ? run_rk4<ImplicitAngle, Law>(q)
                                   : run_rk4<ImplicitTorque, Law>(q);
}

RunResult run_prox(const RunRequest& q) {
    ImplicitProx prox(q);
    return run(q, prox.system,
               [&](double t, double dt, std::vector<double>& y) { prox.step(t, dt, y); });
}

// Explicit model on dry ground: from one recorded time to the next by adaptive steps.
RunResult run_dry(const RunRequest& q) {
    constexpr double kTolerance = 1e-7;
    const double w = q.gait.omega;
    ExplicitAngle<Dry> system(q);
    std::vector<double> y(6);
    system.set(start_chain(q), y.data());
    DryMotion motion(q.robot, q.ground, q.gait);
    Shape shape;
    RunResult out;
    double cx = 0, cy = 0;
    // the body frame of shape.hpp from link 1 and back
    const auto shape_at = [&](double t) {
        shape.set(q.robot, system.gait, std::sin(w * t), std::cos(w * t), false);
    };
    shape_at(0);
    const LinkShape* tail = &shape.link[0];
    double c = std::cos(y[2]), s = std::sin(y[2]);
    DryState state{};
    state.v[DryState::Vx] = c * y[3] + s * y[4] + y[5] * tail->ry - w * tail->rx1;
    state.v[DryState::Vy] = -s * y[3] + c * y[4] - y[5] * tail->rx - w * tail->ry1;
    state.v[DryState::L] = shape.J * y[5] + w * shape.K;
    state.v[DryState::theta] = y[2];
    cx = y[0] - (c * tail->rx - s * tail->ry), cy = y[1] - (s * tail->rx + c * tail->ry);
    const auto note = [&](double t) {
        shape_at(t);
        tail = &shape.link[0];
        const auto& v = state.v;
        c = std::cos(v[DryState::theta]), s = std::sin(v[DryState::theta]);
        const double turn = (v[DryState::L] - w * shape.K) / shape.J;
        const double ux = v[DryState::Vx] - turn * tail->ry + w * tail->rx1;
        const double uy = v[DryState::Vy] + turn * tail->rx + w * tail->ry1;
        const double now[6] = {cx + v[DryState::x] + c * tail->rx - s * tail->ry,
                               cy + v[DryState::y] + s * tail->rx + c * tail->ry,
                               v[DryState::theta],
                               c * ux - s * uy,
                               s * ux + c * uy,
                               turn};
        system.fill(t, now);
        record(out, t, system.chain, nullptr);
    };
    note(0);
    for (long i = 0; i < q.steps; i += q.every) {
        const long to = std::min(i + q.every, q.steps);
        const double t0 = static_cast<double>(i) * q.dt;
        const double t1 = to == q.steps ? q.duration : static_cast<double>(to) * q.dt;
        if (!motion.advance(state, w * t0, w * t1, kTolerance)) {
            out.failed_at = t0;
            break;
        }
        note(t1);
    }
    return out;
}

}  // namespace

RunResult simulate(const RunRequest& q) {
    if (q.method == Method::nonsmooth)
        return q.formulation == Formulation::implicit ? run_prox(q) : run_dry(q);
    if (!q.ground.dry()) return run_law<Viscous>(q);
    return q.smoothing > 0 ? run_law<Smoothed>(q) : run_law<Dry>(q);
}

void evaluate(const RunRequest& q, const double* bend, Chain& chain, Joints& joints) {
    chain.directions();
    if (q.smoothing > 0)
        chain.friction(Smoothed(q.ground, q.smoothing));
    else
        chain.friction(Dry(q.ground));
    const bool angle = q.drive == Drive::angle;
    if (q.formulation == Formulation::explicit_) {
        chain.follow(q.robot.l);
        angle ? explicit_angle(q.robot, bend, chain, joints)
              : explicit_torque(q.robot, chain, joints);
    } else {
        angle ? implicit_angle(q.robot, q.spring, bend, chain, joints)
              : implicit_torque(q.robot, q.spring, chain, joints);
    }
}

}  // namespace serpenoid
