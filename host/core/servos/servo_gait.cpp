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

// Parts of the speed, and counts: with these a claim holds in 95 % of 300 random cases.
struct ServoGaitTuning {
    double min_error = 2e-3;       // an error below it is not claimed
    double fixed_point = 2e-3;     // how far from the fixed point it may be
    double rough_point = 1e-2;     // the same in a search
    double max_step_error = 1e-2;  // by how much it may change with the steps' length
    double hunts = 0.01;           // half its range over the phases of the frames
    double one_speed = 0.25;       // half the range of the means of a loop that hunts
    double many_frames = 60;       // in a cycle: with fewer a cut one shows in its speed
    double max_steps = 1e6;        // in a cycle: more would take minutes
    double swing = 0.7;            // rad of a loop's quickest swing, in a step
    int finest_split = 8;          // parts of a step
    double settling = 5;           // cycles to the fixed point: the mean of 40 random gaits
    int searches = 3;              // searches for the fixed point
};
constexpr ServoGaitTuning kTuning;

// A cycle of the servos' steps as a map of the body's state. Its derivative is learned from one
// cycle to the next (Broyden's update).
class ServoCycle final : public CycleMap {
  public:
    // `monodromy`: the derivative to begin with.
    ServoCycle(ServoSteps& steps, const Robot& robot, const Gait& gait, const Mat3& monodromy)
        : CycleMap(robot, gait, false), steps_(steps), learned_(monodromy) {
        for (int i = 0; i < 2; ++i) {
            learned_[3 * i + 2] *= nm_;
            learned_[6 + i] /= nm_;
        }
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
        CycleEnd end;
        end.state.p = state();
        if (!std::isfinite(end.state.p[0] + end.state.p[1] + end.state.p[2])) return {};
        if (last_) learn(p, end.state.p);
        last_ = {p, end.state.p};
        for (int i = 0; i < 9; ++i) end.state.by_start[i / 3][i % 3] = learned_[i];
        return end;
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

// Cycles until the fixed point is known to a part of the speed, or of a floor of it; the steps then
// continue from it. Returns what Newton's method would still change, m/s; infinite where it finds
// none.
double settle(ServoSteps& steps, ServoCycle& map, double part, double floor) {
    steps.cycle();  // the joints forget their start
    FixedPoint point(map, false);
    const Vec3 &scale = map.scale(), start = map.state();
    for (int i = 0; i < 3; ++i) point.start[i] = start[i] / scale[i];
    const double unit = scale[0] / map.nm();  // m/s
    for (int search = 0; search < kTuning.searches; ++search) {
        Orbit orbit;
        const double goal = part * std::max(steps.path().speed, floor);
        if (point.solve(0, goal / unit, false, orbit) != FixedPoint::Ended::converged) break;
        const double change = unit * std::hypot(orbit.step[0], orbit.step[1], orbit.step[2]);
        if (change > 2 * part * std::max(steps.path().speed, floor)) continue;  // it was faster
        const Vec3& z = point.start;
        map.set_state({z[0] * scale[0], z[1] * scale[1], z[2] * scale[2]});
        return change;
    }
    return HUGE_VAL;
}

struct Range {
    double low = INFINITY, high = 0;

    void add(double value) {
        low = std::min(low, value);
        high = std::max(high, value);
    }
    double half() const { return 0.5 * (high - low); }
};

// The cycles to take from one phase of the frames after another.
struct Plan {
    int phases, forget, keep;
    int cycles() const { return phases * (forget + keep); }
};
// A loop that hunts forgets its start in eight cycles; the mean speed of twelve is compared.
constexpr Plan kHunting{4, 8, 12};

// The mean of all cycles, their speeds, and the mean speeds of the phases. Gains and shifts are
// those of the last cycle.
struct Measured {
    ServoSteps::Path mean;
    Range cycles, phases;
};

Measured measure(ServoSteps& steps, const Plan& plan) {
    using Path = ServoSteps::Path;
    constexpr double Path::* kMeans[] = {&Path::speed,     &Path::turn, &Path::power,
                                         &Path::amplitude, &Path::lag,  &Path::ripple};
    Measured result;
    for (int phase = 0; phase < plan.phases; ++phase) {
        double speeds = 0;
        steps.shift_frames(0.5 + static_cast<double>(phase) / plan.phases);
        for (int k = 0; k < plan.forget; ++k) steps.cycle();
        for (int k = 0; k < plan.keep; ++k) {
            steps.cycle();
            const Path& path = steps.path();
            for (double Path::* value : kMeans)
                result.mean.*value += path.*value / (plan.phases * plan.keep);
            speeds += path.speed;
            result.cycles.add(path.speed);
        }
        result.phases.add(speeds / plan.keep);
    }
    result.mean.gain = steps.path().gain;
    result.mean.shift = steps.path().shift;
    return result;
}

// A loop that hunts remembers more than a cycle, so frames and gait continue as they would from
// each of four phases. Where their mean speeds, or those by longer steps or of single cycles, are
// far apart, there is no one speed, but a range. `report`: measures and reports.
template <class Report>
void follow_hunting(const Report& report, double floor, ServoGaitState& state) {
    Range range;
    range.add(state.speed);
    double difference = 0;
    for (int split : {1, 2}) {
        const double last_speed = state.speed;
        const Range phases = report(split, kHunting);
        range.add(phases.low);
        range.add(phases.high);
        difference = std::hypot(state.speed - last_speed, phases.high - phases.low);
    }
    state.error = 2 * difference + kTuning.hunts * state.speed;
    state.hunts = range.half() > kTuning.one_speed * std::max(state.speed, floor);
    if (!state.hunts) return;
    state.converged = false;
    state.speed = 0.5 * (range.low + range.high);
    state.spread = range.half();
    state.error = range.half();
}

}  // namespace

ServoGaitState servo_gait(const Robot& robot, const Ground& ground, const Gait& gait,
                          const Servo& servo, const Vec3& start, const Mat3& monodromy,
                          double longest, bool rough, double slow, const ServoProgress& progress) {
    const double floor = slow * gait.omega * robot.n * 2 * robot.l;
    const double T = 2 * std::numbers::pi / gait.omega;
    // the loop's spring is explicit in a step: its quickest swing bends the lightest joint alone
    const double swing = std::sqrt(servo.stiffness / (servo.armature + robot.I / 8));
    longest = std::min(longest, kTuning.swing / swing);
    ServoGaitState state;
    state.speed = NAN;
    if (T > kTuning.max_steps * longest) return state;
    ServoSteps steps(robot, ground, gait, servo, longest);
    const bool few_frames = T < kTuning.many_frames * servo.frame;
    const Plan plan{(few_frames ? 4 : 2) / (rough ? 2 : 1), few_frames, 1};
    double done_cycles = 0;
    double all_cycles = kTuning.settling + plan.cycles() * (rough ? 1 : 3);
    if (progress)
        steps.report_steps([&](double share) { progress(done_cycles += share, all_cycles); });
    steps.start(start[0], start[1], start[2]);
    ServoCycle map(steps, robot, gait, monodromy);
    const double change =
        settle(steps, map, rough ? kTuning.rough_point : kTuning.fixed_point, floor);
    state.converged = change < HUGE_VAL;
    // Steps end at frames and updates of the loop, so a shorter limit alone may change little: each
    // step is cut in two.
    const auto report = [&](int split, const Plan& cycles) {
        ServoSteps branch = steps;
        branch.take_steps(2 * longest, split);
        const Measured measured = measure(branch, cycles);
        static_cast<ServoSteps::Path&>(state) = measured.mean;
        state.spread = measured.cycles.half();
        return measured.phases;
    };
    report(1, plan);
    state.error = NAN;
    if (rough) return state;
    if (!state.converged || state.spread > kTuning.hunts * std::max(state.speed, floor)) {
        all_cycles = done_cycles + 3 * kHunting.cycles();
        follow_hunting(report, floor, state);
        return state;
    }
    double by_step = HUGE_VAL;
    for (int split = 2; split <= kTuning.finest_split; split *= 2) {
        if (std::fabs(by_step) <= kTuning.max_step_error * std::max(state.speed, floor)) break;
        const double coarse = state.speed;
        all_cycles = std::max(all_cycles, done_cycles + split * plan.cycles());
        report(split, plan);
        by_step = state.speed - coarse;
    }
    const double by_phase = state.spread / std::sqrt(3.0 * plan.phases);
    // Twice their sum of squares, and two thousandths: this holds 95 % of 300 random cases.
    state.error = 2 * std::hypot(by_step, by_phase, change) + kTuning.min_error * state.speed;
    return state;
}

}  // namespace serpenoid
