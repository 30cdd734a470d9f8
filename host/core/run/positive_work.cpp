// How positive_work.hpp looks into a step.
#include "run/positive_work.hpp"

#include <array>
#include <vector>

#include "numerics/gauss_rule.hpp"
#include "numerics/mean_positive_part.hpp"

namespace serpenoid {

namespace {

template <int nodes>
class PowersOfSteps final : public PositiveWork {
  public:
    PowersOfSteps(System& system, const Method& method)
        : system_(system),
          method_(method),
          y_(system.dim()),
          power_(system.joints().T.size()),
          values_(power_.size()) {
        joints_.reserve(power_.size());
    }

    void step() override {
        done_ = until(to_), from_ = to_, to_ = method_.time();
        for (int k = 0; k < nodes; ++k) {
            const double t = from_ + Gauss<nodes>::get().c[k] * (to_ - from_);
            method_.dense(t, y_.data());
            system_.powers(t, y_.data(), power_);
            for (std::size_t i = 0; i < power_.size(); ++i) values_[i][k] = power_[i];
        }
        joints_.clear();
        for (const auto& values : values_) joints_.emplace_back(values);
    }

    double until(double t) const override {
        if (!(to_ > from_)) return done_;
        const double half = (to_ - from_) / 2, z = t >= to_ ? 1 : (t - from_) / half - 1;
        double sum = 0;
        for (const PositivePart<nodes>& joint : joints_) sum += joint.until(z);
        return done_ + half * sum;
    }

  private:
    System& system_;
    const Method& method_;
    double from_ = 0, to_ = 0, done_ = 0;
    std::vector<double> y_, power_;
    std::vector<std::array<double, nodes>> values_;
    std::vector<PositivePart<nodes>> joints_;
};

}  // namespace

std::unique_ptr<PositiveWork> make_positive_work(System& system, const Method& method) {
    system.ledger()->leave_positive();
    if (method.dense_order() <= 3) return std::make_unique<PowersOfSteps<4>>(system, method);
    return std::make_unique<PowersOfSteps<8>>(system, method);
}

}  // namespace serpenoid
