// Samples and doubts of work_meter.hpp.
#include "periodic/pieces/work_meter.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "numerics/positive_part.hpp"

namespace serpenoid {

namespace {

// How the joints' positive work is sampled, and which wheels make it doubtful.
struct WorkTuning {
    double block = 4.5;              // length of a block at a tolerance of 1, rad
    double min_smooth = 0.08;        // shortest block on smooth ground, rad
    double min_dry = 0.25;           // shortest block on dry ground, rad
    double max_block = 0.5;          // rad: a joint's power changes its sign every pi / 2
    int samples = 5;                 // samples of a block's power
    double max_extrapolation = 0.1;  // fraction of the part of a piece that is used
    // Speeds of doubtful wheels, in units of the aim. Of 8000 random states as many are beyond
    // their claim as with the highest limit for all.
    double slow = 20;        // a fifth of a tolerance
    double aim = 1;          // events are no nearer to zero
    double drifts = 3;       // limit where three wheels rest, over their drift
    int doubt_samples = 64;  // samples of a slow wheel's speed in a piece
};
constexpr WorkTuning kWork;

}  // namespace

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
    active_ = active;
    speed_aim_ = speed_aim;
    max_block_ = std::clamp(kWork.block * std::pow(tolerance, 0.25),
                            piece_.has_modes() ? kWork.min_dry : kWork.min_smooth, kWork.max_block);
    work_ = {std::vector<double>(active ? rate_.size() - 1 : 0)};
    std::fill(fresh_.begin(), fresh_.end(), 0);
}

// The piece is extrapolated over the event steps before it, if they are short.
void WorkMeter::add(const SlidingMode& mode, double h, double x, double skipped) {
    if (!active_) return;
    const double start = -skipped / h;
    const int blocks = static_cast<int>(std::ceil(h * (x - start) / max_block_));
    const double width = (x - start) / blocks;
    const double seconds = h * width / omega_;
    for (int block = 0; block < blocks; ++block) {
        std::array<double, kWork.samples> place;
        for (int q = 0; q < kWork.samples; ++q)
            place[q] = std::max(start + width * (block + q / (kWork.samples - 1.0)),
                                -kWork.max_extrapolation * x);
        piece_.torques(kWork.samples, place.data(), torque_.data(), rate_.data());
        for (std::size_t i = 0; i < work_.positive.size(); ++i) {
            std::array<double, kWork.samples> power;
            for (int q = 0; q < kWork.samples; ++q)
                power[q] = -torque_[i].value[q] * rate_[i].value[q];
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
    const double slow = mode.count < 3 ? kWork.slow
                                       : std::clamp(kWork.drifts * piece_.drift() / speed_aim_,
                                                    kWork.aim, kWork.slow);
    for (int wheel = 0; wheel < piece_.wheels(); ++wheel) {
        if (mode.sign[wheel] == 0 || piece_.law(wheel).bound() == 0) continue;
        if (events_.lower_bound(wheel) >= kWork.slow) {
            fresh_[wheel] = 0;
            continue;
        }
        const StagePolynomial<SlidingPiece::kStages> margin(events_.margins(wheel));
        int count = 0;
        for (int k = 0; k < kWork.doubt_samples; ++k)
            count += margin(x * (k + 0.5) / kWork.doubt_samples) < slow;
        if (!fresh_[wheel])
            work_.error += piece_.law(wheel).bound() * lever_ * h * x * count / kWork.doubt_samples;
        if (margin(x) >= kWork.slow) fresh_[wheel] = 0;
    }
}

}  // namespace serpenoid
