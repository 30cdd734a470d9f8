// The secant method and the mean of servo_gait.hpp.
#include "servos/servo_gait.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "servos/servo_steps.hpp"

namespace serpenoid {

namespace {

constexpr double kMany = 60;        // frames in a cycle: fewer, and a cut one shows in it
constexpr double kMostSteps = 1e6;  // in a cycle
constexpr double kLeast = 2e-3;     // of the speed: an error below it is not claimed
constexpr double kSwing = 0.7;      // of a loop's quickest swing, rad: a step
constexpr double kRough = 1e-2;     // of the speed: what a search may leave of the settling
constexpr double kHunts = 0.05;     // of the speed, by the phase of the frames
constexpr double kFarthest = 30;    // times the residual: a step of the secant method

class Settling {
  public:
    Settling(ServoSteps& steps, const Robot& robot, const Mat3& monodromy, double least)
        : steps_(steps), least_(least), turn_(1 / (robot.n * robot.m * 2 * robot.l * robot.n)) {
        for (int i = 0; i < 9; ++i) B_[i] = (i % 4 == 0) - monodromy[i] * unit(i / 3) / unit(i % 3);
    }

    // Take cycles until the next step of the method changes less than a part of the speed.
    bool run(double part, int most) {
        steps_.cycle();  // the joints forget their start
        Vec3 r{}, d{};
        for (cycles = 1; cycles <= most; ++cycles) {
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
    int cycles = 0;
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

// Mean and range of the speeds of cycles.
class Mean {
  public:
    void add(const ServoSteps::Path& p) {
        low_ = count_ == 0 ? p.speed : std::min(low_, p.speed);
        high_ = count_ == 0 ? p.speed : std::max(high_, p.speed);
        ++count_;
        sum_.speed += p.speed, sum_.turn += p.turn, sum_.power += p.power;
        sum_.amplitude += p.amplitude, sum_.lag += p.lag, sum_.ripple += p.ripple;
        sum_.gain = p.gain, sum_.shift = p.shift;
    }
    void report(ServoGaitState& to) const {
        to.gain = sum_.gain, to.shift = sum_.shift;
        to.speed = sum_.speed / count_, to.turn = sum_.turn / count_;
        to.power = sum_.power / count_, to.amplitude = sum_.amplitude / count_;
        to.lag = sum_.lag / count_, to.ripple = sum_.ripple / count_;
        to.spread = 0.5 * (high_ - low_);
    }
    double speed() const { return sum_.speed / count_; }

  private:
    ServoSteps::Path sum_;
    double low_ = 0, high_ = 0;
    int count_ = 0;
};

// Cycles whose frames begin `phases` parts of a frame after one another.
Mean measure(ServoSteps& steps, int phases, bool forget) {
    Mean mean;
    for (int j = 0; j < phases; ++j) {
        steps.shift_frames(0.5 + static_cast<double>(j) / phases);
        if (forget) steps.cycle();
        steps.cycle();
        mean.add(steps.path());
    }
    return mean;
}

}  // namespace

ServoGaitState servo_gait(const Robot& robot, const Ground& ground, const Gait& gait,
                          const Servo& servo, const Vec3& start, const Mat3& monodromy,
                          const ServoGaitOptions& options) {
    const double least = 1e-4 * gait.omega * robot.n * 2 * robot.l;
    const double frames = 2 * std::numbers::pi / (gait.omega * servo.frame);
    // the loop's spring is explicit in a step: its quickest swing bends the lightest joint alone
    const double swing = std::sqrt(servo.stiffness / (servo.armature + robot.I / 8));
    const double longest = std::min(options.longest, kSwing / swing);
    ServoGaitState out;
    if (2 * std::numbers::pi / (gait.omega * longest) > kMostSteps) return out;
    ServoSteps steps(robot, ground, gait, servo, longest);
    steps.start(start[0], start[1], start[2]);
    Settling settling(steps, robot, monodromy, least);
    out.converged = settling.run(options.rough ? kRough : options.settled, options.most_cycles);
    out.cycles = settling.cycles;
    const bool few = frames < kMany;
    const int most = options.rough ? (options.phases + 1) / 2 : options.phases;
    const int phases = few ? most : (most + 1) / 2;
    steps.set_body(settling.last.data());
    // Steps end at frames and looks of the loop, so a shorter limit alone may change little: each
    // step is cut in two.
    const auto at = [&](int split) {
        ServoSteps again = steps;
        again.take_steps(2 * longest, split), again.watch(options.watch);
        const Mean mean = measure(again, phases, few);
        out.lines = again.lines();
        return mean;
    };
    int split = 2;
    Mean coarse = at(1);
    coarse.report(out), out.error = NAN;
    if (options.rough) return out;
    Mean fine = at(split);
    double by_step = fine.speed() - coarse.speed();
    for (int finer = 0; finer < options.most_halvings; ++finer) {
        if (std::fabs(by_step) <= options.rtol * std::max(fine.speed(), least)) break;
        coarse = fine, fine = at(split *= 2), by_step = fine.speed() - coarse.speed();
    }
    fine.report(out);
    // A loop that hunts has states of its own, and the phases need not find the one that it takes.
    const bool hunts = out.spread > kHunts * out.speed;
    const double by_phase = hunts ? out.spread : out.spread / std::sqrt(3.0 * phases);
    // twice their sum of squares, and two thousandths: holds 95 % of 300 random cases
    const double apart = std::hypot(by_step, by_phase, settling.left);
    out.error = 2 * apart + kLeast * out.speed;
    return out;
}

}  // namespace serpenoid
