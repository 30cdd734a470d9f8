// How positive_work.hpp looks into a step.
#include "run/positive_work.hpp"

#include "numerics/positive_part.hpp"

namespace serpenoid {

PositiveWork::PositiveWork(System& system, const Method& method)
    : system_(system),
      method_(method),
      y_(system.dim()),
      power_(system.joints().T.size()),
      samples_(power_.size()) {
    system.ledger()->leave_positive();
}

void PositiveWork::step() {
    done_ = until(end_);
    start_ = end_;
    end_ = method_.time();
    for (int k = 0; k <= 2 * kPanels; ++k) {
        const double t = start_ + k * (end_ - start_) / (2 * kPanels);
        method_.dense(t, y_.data());
        system_.powers(t, y_.data(), power_);
        for (std::size_t i = 0; i < power_.size(); ++i) samples_[i][k] = power_[i];
    }
}

double PositiveWork::until(double t) const {
    if (!(end_ > start_)) return done_;
    const double width = (end_ - start_) / kPanels;
    double work = done_;
    for (int panel = 0; panel < kPanels && t > start_ + panel * width; ++panel) {
        const double part = std::min(1.0, (t - start_) / width - panel);
        for (const auto& joint : samples_) {
            const double* power = &joint[2 * panel];
            work += width * positive_integral(power[0], power[1], power[2], part);
        }
    }
    return work;
}

}  // namespace serpenoid
