// Runs one rung of the ladder of scenes for so many RK4 steps; callgrind counts what that takes.
//
//     ladder FORMULATION RUNG STEPS     prints the end of link 1, so that nothing is optimised away
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "handwritten.hpp"
#include "run/simulation.hpp"

namespace {

constexpr double kDegree = 3.14159265358979323846 / 180, kStep = 1e-3;
const handwritten::Plain kPlain{6,   1.0, 0.06, 0.0012, 0.1, 10.0, 30 * kDegree, 80 * kDegree,
                                5.0, 1e3, 1.0};

template <class Kernel>
double by_hand(long steps) {
    const Kernel kernel(kPlain);
    std::vector<double> y = kernel.start(), work[5];
    for (auto& w : work) w.resize(y.size());
    for (long i = 0; i < steps; ++i)
        handwritten::rk4(kernel, static_cast<double>(i) * kStep, kStep, y, work);
    return y[0];
}

// Every rung adds to the plain scene one thing, or to the rung before where it says so.
bool climb(const std::string& rung, serpenoid::RunRequest& q) {
    if (rung == "viscous") return true;
    if (rung == "bingham") return q.ground = {kPlain.ct, kPlain.cn, 0.02, 0.05}, true;
    if (rung == "ratchet") return climb("bingham", q), q.ground.ft0_back = 0.2, true;
    if (rung == "incline") return climb("bingham", q), q.slope = {-0.5, 0}, true;
    if (rung == "servo") {
        climb("incline", q);
        q.drive = serpenoid::Drive::servo;
        q.servo = {3.0, 0.03, 0.3, 8.7, 0.01};
        return true;
    }
    if (rung == "record forces") {
        climb("servo", q);
        q.every = 1, q.record_joints = q.record_friction = true;
        return true;
    }
    if (rung == "energy ledger") return climb("servo", q), q.record_energy = true, true;
    if (rung == "record motion") return q.every = 1, true;
    return false;
}

double composed(bool implicit, const std::string& rung, long steps) {
    serpenoid::RunRequest q;
    const auto& p = kPlain;
    q.robot = {p.n, p.m, p.l, p.I};
    q.ground = {p.ct, p.cn, 0, 0};
    q.gait = {p.alpha, p.beta, p.omega, 0};
    q.formulation = implicit ? serpenoid::Formulation::implicit : serpenoid::Formulation::explicit_;
    q.spring = {p.k, p.c};
    q.dt = kStep, q.duration = kStep * static_cast<double>(steps);
    q.steps = q.every = steps, q.most_steps = 2 * steps;
    q.start.assign(6 * p.n, 0.0);
    for (int i = 0; i < p.n; ++i) q.start[i] = 2 * p.l * i;
    if (!climb(rung, q)) std::exit(2);
    const std::vector<double> x = serpenoid::simulate(q).x;
    return x[x.size() - p.n];  // link 1, as by hand
}

}  // namespace

int main(int, char** argument) {
    const bool implicit = std::string(argument[1]) == "implicit";
    const std::string rung = argument[2];
    const long steps = std::atol(argument[3]);
    double end;
    if (rung == "by hand")
        end = implicit ? by_hand<handwritten::Implicit>(steps)
                       : by_hand<handwritten::Explicit>(steps);
    else
        end = composed(implicit, rung, steps);
    std::printf("%.17g\n", end);
}
