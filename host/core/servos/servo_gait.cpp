// The secant method and the mean of servo_gait.hpp.
#include "servos/servo_gait.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace serpenoid {

namespace {

constexpr double kMany = 60;         // frames in a cycle: fewer, and a cut one shows in it
constexpr double kMostSteps = 1e6;   // in a cycle
constexpr double kLeast = 2e-3;      // of the speed: an error below it is not claimed
constexpr double kSwing = 0.7;       // of a loop's quickest swing, rad: a step
constexpr int kMostCycles = 60;      // to settle in
constexpr double kNearFixed = 2e-3;  // of the speed: how far from the fixed point it may be
constexpr double kRough = 1e-2;      // the same in a search
constexpr int kFinest = 8;           // parts of a step, where the speed hangs on it
constexpr double kByStep = 1e-2;     // of the speed: by how much it may
constexpr double kHunts = 0.01;      // of the speed: half its range over the phases of the frames
constexpr int kForgets = 8;          // cycles in which a loop that hunts leaves its start behind
constexpr int kFollowed = 12;        // cycles whose mean speed is compared with others'
constexpr double kOneSpeed = 0.25;   // of the speed: half the range that such means may have
constexpr double kFarthest = 30;     // times the residual: a step of the secant method

class Settling {
  public:
    Settling(ServoSteps& steps, const Robot& robot, const Mat3& monodromy, double least)
        : steps_(steps), least_(least), turn_(1 / (robot.n * robot.m * 2 * robot.l * robot.n)) {
        for (int i = 0; i < 9; ++i) B_[i] = (i % 4 == 0) - monodromy[i] * unit(i / 3) / unit(i % 3);
    }

    // Take cycles until the next step of the method changes less than a part of the speed.
    bool run(double part) {
        steps_.cycle();  // the joints forget their start
        Vec3 r{}, d{};
        for (int cycles = 1; cycles <= kMostCycles; ++cycles) {
            const Vec3 from = state();
            steps_.body(last.data());
            steps_.shift_frames(0.5);
            steps_.cycle();
            const Vec3 before = r;
            r = state();
            for (int i = 0; i < 3; ++i) r[i] -= from[i];
            if (cycles > 1) learn(before, r, d);
            d = step(r);
            left = size(d);
            if (!(left < 1e300)) return false;
            if (left <= part * std::max(steps_.path().speed, least_)) return true;
            Vec3 to = from;
            for (int i = 0; i < 3; ++i) to[i] = (to[i] + d[i]) / unit(i);
            steps_.set_body(to.data());
        }
        return false;
    }
    double left = 0;  // m/s
    Vec3 last{};      // the body's state before the last cycle

  private:
    double unit(int i) const { return i == 2 ? turn_ : 1; }
    static double size(const Vec3& a) { return std::hypot(a[0], a[1], a[2]); }
    Vec3 state() const {  // the momentum as a speed
        Vec3 x;
        steps_.body(x.data());
        x[2] *= turn_;
        return x;
    }
    Vec3 step(const Vec3& r) const {
        Mat3 A = B_;
        Vec3 d = r;
        if (!solve_dense<3, 1>(A.data(), d.data())) d = r;
        const double most = std::min(kFarthest * size(r), std::max(steps_.path().speed, least_));
        const double far = size(d);
        if (!(far <= most))
            for (int i = 0; i < 3; ++i) d[i] = far < 1e300 ? d[i] * most / far : r[i];
        return d;
    }
    // Broyden's update: r falls by B d along d.
    void learn(const Vec3& before, const Vec3& now, const Vec3& d) {
        const double square = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
        if (!(square > 0)) return;
        const Vec3 foretold = multiply(B_, d);
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
                B_[3 * i + j] += (before[i] - now[i] - foretold[i]) * d[j] / square;
    }
    ServoSteps& steps_;
    double least_, turn_;
    Mat3 B_;
};

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
};
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
        const Mean phases = at(split, {4, kForgets, kFollowed});
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
                          double longest, bool rough, std::vector<int> watch) {
    const double least = 1e-4 * gait.omega * robot.n * 2 * robot.l;
    const double T = 2 * std::numbers::pi / gait.omega;
    // the loop's spring is explicit in a step: its quickest swing bends the lightest joint alone
    const double swing = std::sqrt(servo.stiffness / (servo.armature + robot.I / 8));
    longest = std::min(longest, kSwing / swing);
    ServoGaitState out;
    out.speed = NAN;
    if (T > kMostSteps * longest) return out;
    ServoSteps steps(robot, ground, gait, servo, longest);
    steps.start(start[0], start[1], start[2]);
    Settling settling(steps, robot, monodromy, least);
    out.converged = settling.run(rough ? kRough : kNearFixed);
    const bool few = T < kMany * servo.frame;
    const int phases = (few ? 4 : 2) / (rough ? 2 : 1);  // of the frames in the gait
    steps.set_body(settling.last.data());
    // Steps end at frames and looks of the loop, so a shorter limit alone may change little: each
    // step is cut in two.
    const auto at = [&](int split, const Plan& plan) {
        ServoSteps again = steps;
        again.take_steps(2 * longest, split), again.watch(watch);
        const Measured found = measure(again, plan);
        found.cycles.report(out), out.lines = again.lines();
        return found.phases;
    };
    const Plan plan{phases, few, 1};
    at(1, plan), out.error = NAN;
    if (rough) return out;
    if (out.spread > kHunts * std::max(out.speed, least)) return follow(at, least, out), out;
    double by_step = HUGE_VAL;
    for (int split = 2; split <= kFinest; split *= 2) {
        if (std::fabs(by_step) <= kByStep * std::max(out.speed, least)) break;
        const double coarse = out.speed;
        at(split, plan), by_step = out.speed - coarse;
    }
    const double by_phase = out.spread / std::sqrt(3.0 * phases);
    // twice their sum of squares, and two thousandths: holds 95 % of 300 random cases
    const double apart = std::hypot(by_step, by_phase, settling.left);
    out.error = 2 * apart + kLeast * out.speed;
    return out;
}

}  // namespace serpenoid
