// Runs and measured derivatives of general_cycle.hpp.
#include "periodic/general_cycle.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "body/frame_change.hpp"
#include "run/make_method.hpp"
#include "run/positive_work.hpp"
#include "scene/energy_ledger.hpp"
#include "scene/make_system.hpp"

namespace serpenoid {

namespace {

// A system with the way of its centre of mass behind the state, in axes that turn evenly.
class TurningPath final : public System {
  public:
    TurningPath(std::unique_ptr<System> of, double turn_rad_s)
        : System(*of), inner_(std::move(of)), turn_(turn_rad_s) {}

    int dim() const override { return inner_->dim() + 2; }
    void set(const Chain& from, double* y) const override {
        inner_->set(from, y);
        std::fill_n(y + inner_->dim(), 2, 0.0);
    }
    void fill(double t, const double* y) override { inner_->fill(t, y); }
    void forces(double t, const double* y) override { inner_->forces(t, y); }
    void rate(double t, const double* y, double* dy) override {
        inner_->rate(t, y, dy);
        if (!inner_->rate_fills_forces()) inner_->forces(t, y);
        double vx = 0, vy = 0;
        for (int i = 0; i < chain.n(); ++i) vx += chain.vx[i], vy += chain.vy[i];
        const double c = std::cos(turn_ * t) / chain.n(), s = std::sin(turn_ * t) / chain.n();
        dy[inner_->dim()] = c * vx + s * vy, dy[inner_->dim() + 1] = c * vy - s * vx;
    }
    bool rate_fills_forces() const override { return true; }
    std::vector<int> rate_of() const override {
        std::vector<int> of = inner_->rate_of();
        of.resize(dim(), -1);
        return of;
    }
    Modes* modes() override { return inner_->modes(); }

  private:
    std::unique_ptr<System> inner_;
    double turn_;
};

TailFrame frame_at(const RunRequest& q, const GaitTable& table, double phase) {
    BodyShape shape;
    shape.set(q.robot, table, std::sin(phase), std::cos(phase), false);
    return TailFrame(shape);
}

}  // namespace

GeneralCycle::GeneralCycle(const Robot& robot, const Ground& ground, const Gait& gait,
                           long most_steps)
    : CycleMap(robot, gait), most_steps_(most_steps) {
    request_.robot = robot, request_.ground = ground, request_.gait = gait;
    request_.method = method_kind("nonsmooth");
}

std::optional<CycleEnd> GeneralCycle::run(const Vec3& p, const Following& how) {
    request_.tolerance = how.tolerance;
    EnergyLedger ledger(
        std::make_unique<TurningPath>(make_system(request_), how.spin * gait_.omega), request_);
    const std::unique_ptr<Method> method = make_method(request_, ledger);
    std::unique_ptr<PositiveWork> positive;
    if (how.work) positive = make_positive_work(ledger, *method);
    std::vector<double> y(ledger.dim());
    const BodyState start{0, 0, 0, p[0] / nm_, p[1] / nm_, p[2]};
    frame_at(request_, table_, 0).tail(start, gait_.omega, y.data());
    method->restart(0, y.data());
    while (method->time() < time()) {
        if (++steps_ > most_steps_ || !method->step(time()).ok) return {};
        if (positive) positive->step();
    }
    const double* const end = method->state();
    const BodyState body = frame_at(request_, table_, span()).body(end, gait_.omega);
    const std::size_t heat = EnergyLedger::heat_at(y.size()), path = heat - 3;
    CycleEnd to;
    to.state.p = {nm_ * body.Vx, nm_ * body.Vy, body.L};
    to.state.theta = body.theta, to.state.x = end[path], to.state.y = end[path + 1];
    to.state.dissipated = end[heat];
    if (how.work) to.work = {{positive->until(time())}, end[heat - 1]};
    return to;
}

std::optional<CycleEnd> GeneralCycle::follow(const Vec3& p, const Following& how) {
    std::optional<CycleEnd> to = run(p, how);
    if (!to || !how.derivative) return to;
    const auto rows = [](const CycleState& s) {
        return std::array{s.p[0], s.p[1], s.p[2], s.theta, s.x, s.y, s.dissipated};
    };
    const double part = std::max(1e-6, 0.1 * std::sqrt(how.tolerance));
    const auto end = rows(to->state);
    for (int j = 0; j < 3; ++j) {
        Vec3 beside = p;
        beside[j] += part * scale_[j];
        const auto moved = run(beside, {how.tolerance});
        if (!moved) return {};
        const auto there = rows(moved->state);
        for (int i = 0; i < CycleState::kRows; ++i)
            to->state.by_start[i][j] = (there[i] - end[i]) / (part * scale_[j]);
    }
    return to;
}

std::optional<Mat3> GeneralCycle::measured_derivative(const Vec3& p, const Following& how,
                                                      double distance) {
    Mat3 M;
    for (int j = 0; j < 3; ++j) {
        Vec3 ahead = p, behind = p;
        ahead[j] += distance * scale_[j], behind[j] -= distance * scale_[j];
        const auto up = run(ahead, how), down = run(behind, how);
        if (!up || !down) return {};
        for (int i = 0; i < 3; ++i)
            M[3 * i + j] = (up->state.p[i] - down->state.p[i]) / (2 * distance * scale_[j]);
    }
    return M;
}

}  // namespace serpenoid
