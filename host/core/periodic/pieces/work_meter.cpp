// Samples and doubts of work_meter.hpp.
#include "periodic/pieces/work_meter.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "numerics/positive_part.hpp"

namespace serpenoid {

WorkMeter::WorkMeter(const Robot& robot, const Gait& gait, SlidingPiece& piece,
                     const EventFinder& events)
    : omega_(gait.omega),
      lever_(2 * robot.l * gait.alpha * robot.n / 4),
      piece_(piece),
      events_(events),
      torque_(robot.n),
      rate_(robot.n),
      fresh_(2 * robot.n) {}

// Errors go with the fourth power of a block: as the tolerance, until positive power is known to
// 1e-6 on smooth ground. On dry ground 1e-4 will do: sticking forces are not known better.
void WorkMeter::start(bool active, double tolerance, double speed_aim) {
    constexpr double kBlock = 4.5;       // rad, at a tolerance of 1
    constexpr double kMinSmooth = 0.08;  // rad
    constexpr double kMinDry = 0.25;     // rad
    constexpr double kMaxBlock = 0.5;    // rad: a joint's power changes its sign every pi / 2
    active_ = active;
    speed_aim_ = speed_aim;
    max_block_ = std::clamp(kBlock * std::pow(tolerance, 0.25),
                            piece_.has_modes() ? kMinDry : kMinSmooth, kMaxBlock);
    work_ = {std::vector<double>(active ? rate_.size() - 1 : 0)};
    std::fill(fresh_.begin(), fresh_.end(), 0);
}

// The piece is extrapolated over the event steps before it, if they are short.
void WorkMeter::add(const SlidingMode& mode, double h, double x, double skipped) {
    constexpr int kSamples = 5;
    constexpr double kFarthest = 0.1;  // of the part that is used
    if (!active_) return;
    const double start = -skipped / h;
    const int blocks = static_cast<int>(std::ceil(h * (x - start) / max_block_));
    const double width = (x - start) / blocks;
    const double seconds = h * width / omega_;
    for (int block = 0; block < blocks; ++block) {
        std::array<double, kSamples> place;
        for (int q = 0; q < kSamples; ++q)
            place[q] = std::max(start + width * (block + q / (kSamples - 1.0)), -kFarthest * x);
        piece_.torques(kSamples, place.data(), torque_.data(), rate_.data());
        for (std::size_t i = 0; i < work_.positive.size(); ++i) {
            std::array<double, kSamples> power;
            for (int q = 0; q < kSamples; ++q) power[q] = -torque_[i].value[q] * rate_[i].value[q];
            const PositiveMean mean(power.data());
            work_.positive[i] += seconds * mean.value;
            work_.error += seconds * mean.error;
            work_.net += seconds * mean.net;
        }
    }
    add_doubt(mode, h, x);
}

// A wheel whose speed dips close to zero may rest there or not: the mode is ambiguous at this
// tolerance. While it is so slow, its force and those of wheels at rest are uncertain by its dry
// friction; the speeds hardly change. A wheel that has just begun to slide is slow, too, but its
// mode is certain. Where three wheels rest, the shape alone moves the others: their speeds are
// known as well as those that rest are held.
void WorkMeter::add_doubt(const SlidingMode& mode, double h, double x) {
    // Speeds in units of the aim. Of 8000 random states as many are beyond their claim as with the
    // highest limit for all.
    constexpr double kSlow = 20;   // a fifth of a tolerance
    constexpr double kAim = 1;     // events are no nearer to zero
    constexpr double kDrifts = 3;  // of what rests
    constexpr int kSamples = 64;
    const double slow =
        mode.count < 3 ? kSlow : std::clamp(kDrifts * piece_.drift() / speed_aim_, kAim, kSlow);
    for (int wheel = 0; wheel < piece_.wheels(); ++wheel) {
        if (mode.sign[wheel] == 0 || piece_.law(wheel).bound() == 0) continue;
        if (events_.lower_bound(wheel) >= kSlow) {
            fresh_[wheel] = 0;
            continue;
        }
        const StagePolynomial<SlidingPiece::kStages> margin(events_.margins(wheel));
        int count = 0;
        for (int k = 0; k < kSamples; ++k) count += margin(x * (k + 0.5) / kSamples) < slow;
        if (!fresh_[wheel])
            work_.error += piece_.law(wheel).bound() * lever_ * h * x * count / kSamples;
        if (margin(x) >= kSlow) fresh_[wheel] = 0;
    }
}

}  // namespace serpenoid
