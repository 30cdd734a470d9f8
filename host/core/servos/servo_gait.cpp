// The secant method and the mean of servo_gait.hpp.
#include "servos/servo_gait.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "periodic/fixed_point.hpp"

namespace serpenoid {

namespace {

constexpr double kMany = 60;         // frames in a cycle: fewer, and a cut one shows in it
constexpr double kMostSteps = 1e6;   // in a cycle
constexpr double kLeast = 2e-3;      // of the speed: an error below it is not claimed
constexpr double kSwing = 0.7;       // of a loop's quickest swing, rad: a step
constexpr double kNearFixed = 2e-3;  // of the speed: how far from the fixed point it may be
constexpr double kRough = 1e-2;      // the same in a search
constexpr int kFinest = 8;           // parts of a step, where the speed hangs on it
constexpr double kByStep = 1e-2;     // of the speed: by how much it may
constexpr double kHunts = 0.01;      // of the speed: half its range over the phases of the frames
constexpr int kForgets = 8;          // cycles in which a loop that hunts leaves its start behind
constexpr int kFollowed = 12;        // cycles whose mean speed is compared with others'
constexpr double kOneSpeed = 0.25;   // of the speed: half the range that such means may have
constexpr double kSettles = 5;       // cycles to the fixed point: the mean of 40 random gaits

// A cycle of the servos' steps as a map of the body's state. Its derivative is learned from one
// cycle to the next (Broyden's update).
class ServoCycle final : public CycleMap {
  public:
    // `monodromy`: the derivative to begin with.
    ServoCycle(ServoSteps& steps, const Robot& robot, const Gait& gait, const Mat3& monodromy)
        : CycleMap(robot, gait, false), steps_(steps), learned_(monodromy) {
        for (int i = 0; i < 2; ++i) learned_[3 * i + 2] *= nm_, learned_[6 + i] /= nm_;
    }

    Vec3 state() const {
        Vec3 p;
        steps_.body(p.data());
        return {nm_ * p[0], nm_ * p[1], p[2]};
    }
    void set_state(const Vec3& p) {
        const Vec3 body{p[0] / nm_, p[1] / nm_, p[2]};
        steps_.set_body(body.data());
    }

    std::optional<CycleEnd> follow(const Vec3& p, const Following&) override {
        set_state(p);
        steps_.shift_frames(0.5);
        steps_.cycle();
        CycleEnd to;
        to.state.p = state();
        if (!std::isfinite(to.state.p[0] + to.state.p[1] + to.state.p[2])) return {};
        if (last_) learn(p, to.state.p);
        last_ = {p, to.state.p};
        for (int i = 0; i < 9; ++i) to.state.by_start[i / 3][i % 3] = learned_[i];
        return to;
    }

  private:
    void learn(const Vec3& start, const Vec3& end) {
        Vec3 d, miss;
        for (int i = 0; i < 3; ++i) d[i] = (start[i] - last_->first[i]) / scale_[i];
        const double square = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
        if (!(square > 0)) return;
        for (int i = 0; i < 3; ++i) {
            miss[i] = end[i] - last_->second[i];
            for (int j = 0; j < 3; ++j) miss[i] -= learned_[3 * i + j] * d[j] * scale_[j];
        }
        for (int i = 0; i < 9; ++i)
            learned_[i] += miss[i / 3] * d[i % 3] / (square * scale_[i % 3]);
    }

    ServoSteps& steps_;
    Mat3 learned_;
    std::optional<std::pair<Vec3, Vec3>> last_;  // start and end of the cycle before
};

// Cycles until the fixed point is known to a part of the speed; the steps then go on from it.
// Returns what Newton's method would still change, m/s; infinite where it finds none.
double settle(ServoSteps& steps, ServoCycle& map, double part, double least) {
    steps.cycle();  // the joints forget their start
    FixedPoint point(map, false);
    const Vec3 &scale = map.scale(), start = map.state();
    for (int i = 0; i < 3; ++i) point.start[i] = start[i] / scale[i];
    const double unit = scale[0] / map.nm();  // m/s
    for (int again = 0; again < 3; ++again) {
        Orbit orbit;
        const double goal = part * std::max(steps.path().speed, least) / unit;
        if (point.solve(0, goal, false, orbit) != FixedPoint::Ended::converged) break;
        const double left = unit * std::hypot(orbit.step[0], orbit.step[1], orbit.step[2]);
        if (left > 2 * part * std::max(steps.path().speed, least)) continue;  // it was faster
        const Vec3& z = point.start;
        map.set_state({z[0] * scale[0], z[1] * scale[1], z[2] * scale[2]});
        return left;
    }
    return HUGE_VAL;
}

// Mean and range of the speeds of cycles; gains and shifts are those of the last one.
class Mean {
  public:
    using Path = ServoSteps::Path;
    void add(const Path& p) {
        low = std::min(low, p.speed), high = std::max(high, p.speed);
        ++count_;
        for (double Path::* value : kValues) sum_.*value += p.*value;
        sum_.gain = p.gain, sum_.shift = p.shift;
    }
    Path path() const {
        Path mean = sum_;
        for (double Path::* value : kValues) mean.*value /= count_;
        return mean;
    }
    void report(ServoGaitState& to) const {
        static_cast<Path&>(to) = path(), to.spread = 0.5 * (high - low);
    }
    double low = INFINITY, high = 0;

  private:
    static constexpr double Path::* kValues[] = {&Path::speed,     &Path::turn, &Path::power,
                                                 &Path::amplitude, &Path::lag,  &Path::ripple};
    Path sum_;
    int count_ = 0;
};

// The cycles to take from one phase of the frames after another.
struct Plan {
    int phases, forget, keep;
    int cycles() const { return phases * (forget + keep); }
};
constexpr Plan kFollow{4, kForgets, kFollowed};
struct Measured {
    Mean cycles, phases;
};
Measured measure(ServoSteps& steps, const Plan& plan) {
    Measured to;
    for (int j = 0; j < plan.phases; ++j) {
        Mean phase;
        steps.shift_frames(0.5 + static_cast<double>(j) / plan.phases);
        for (int k = 0; k < plan.forget; ++k) steps.cycle();
        for (int k = 0; k < plan.keep; ++k) {
            steps.cycle();
            phase.add(steps.path()), to.cycles.add(steps.path());
        }
        to.phases.add(phase.path());
    }
    return to;
}

// A loop that hunts remembers more than a cycle, so frames and gait go on as they would from each
// of four phases. Where their mean speeds, or those by longer steps or of single cycles, are far
// apart, there is no one speed, but a range. `at`: measures and reports.
template <class At>
void follow(const At& at, double least, ServoGaitState& out) {
    double low = out.speed, high = out.speed, apart = 0;
    for (int split : {1, 2}) {
        const double before = out.speed;
        const Mean phases = at(split, kFollow);
        low = std::min(low, phases.low), high = std::max(high, phases.high);
        apart = std::hypot(out.speed - before, phases.high - phases.low);
    }
    out.error = 2 * apart + kHunts * out.speed;
    out.hunts = 0.5 * (high - low) > kOneSpeed * std::max(out.speed, least);
    if (!out.hunts) return;
    out.converged = false;
    out.speed = 0.5 * (low + high), out.spread = out.error = 0.5 * (high - low);
}

}  // namespace

ServoGaitState servo_gait(const Robot& robot, const Ground& ground, const Gait& gait,
                          const Servo& servo, const Vec3& start, const Mat3& monodromy,
                          double longest, bool rough, double slow, const ServoProgress& progress) {
    const double least = slow * gait.omega * robot.n * 2 * robot.l;
    const double T = 2 * std::numbers::pi / gait.omega;
    // the loop's spring is explicit in a step: its quickest swing bends the lightest joint alone
    const double swing = std::sqrt(servo.stiffness / (servo.armature + robot.I / 8));
    longest = std::min(longest, kSwing / swing);
    ServoGaitState out;
    out.speed = NAN;
    if (T > kMostSteps * longest) return out;
    ServoSteps steps(robot, ground, gait, servo, longest);
    const bool few = T < kMany * servo.frame;
    const int phases = (few ? 4 : 2) / (rough ? 2 : 1);  // of the frames in the gait
    const Plan plan{phases, few, 1};
    double done_cycles = 0, all_cycles = kSettles + plan.cycles() * (rough ? 1 : 3);
    if (progress)
        steps.report_steps([&](double share) { progress(done_cycles += share, all_cycles); });
    steps.start(start[0], start[1], start[2]);
    ServoCycle map(steps, robot, gait, monodromy);
    const double left = settle(steps, map, rough ? kRough : kNearFixed, least);
    out.converged = left < HUGE_VAL;
    // Steps end at frames and looks of the loop, so a shorter limit alone may change little: each
    // step is cut in two.
    const auto at = [&](int split, const Plan& plan) {
        ServoSteps again = steps;
        again.take_steps(2 * longest, split);
        const Measured found = measure(again, plan);
        found.cycles.report(out);
        return found.phases;
    };
    at(1, plan), out.error = NAN;
    if (rough) return out;
    if (!out.converged || out.spread > kHunts * std::max(out.speed, least)) {
        all_cycles = done_cycles + 3 * kFollow.cycles();
        return follow(at, least, out), out;
    }
    double by_step = HUGE_VAL;
    for (int split = 2; split <= kFinest; split *= 2) {
        if (std::fabs(by_step) <= kByStep * std::max(out.speed, least)) break;
        const double coarse = out.speed;
        all_cycles = std::max(all_cycles, done_cycles + split * plan.cycles());
        at(split, plan), by_step = out.speed - coarse;
    }
    const double by_phase = out.spread / std::sqrt(3.0 * phases);
    // twice their sum of squares, and two thousandths: holds 95 % of 300 random cases
    const double apart = std::hypot(by_step, by_phase, left);
    out.error = 2 * apart + kLeast * out.speed;
    return out;
}

}  // namespace serpenoid
