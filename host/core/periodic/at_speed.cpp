// The packs of at_speed.hpp, and the cubics through them.
#include "periodic/at_speed.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace serpenoid {

namespace {

constexpr int kNodes = 4, kValues = 4;
constexpr double kFar = 9;  // e-folds of rate from the guess
constexpr double kLargestStep = 1.1;
constexpr double kStepBlind = 0.7;   // where the slope of speed against rate says nothing
constexpr double kLeastSlope = 0.1;  // of ln speed against ln rate
constexpr double kNearMiss = 30;     // times the accuracy asked for: a state this good counts
constexpr double kAgree = 10;        // times it: how far quadratics may be off, cubics are not
constexpr double kLeastSpread = 1e-3, kMostSpread = 0.3;
constexpr int kMostPacks = 40;

// A rate's ln, its ln speed over the wish, and the ln of its rate and powers.
struct Node {
    double x = 0, y = 0;
    std::array<double, kValues> value{};
    double error = 0;
    bool good = false;
};
using Pack = std::array<Node, kNodes>;

// Values at y = 0 of the polynomial through the nodes from `first` up to, not including, `last`.
std::array<double, kValues> at_zero(const Pack& p, int first, int last) {
    std::array<double, kValues> sum{};
    for (int i = first; i < last; ++i) {
        double weight = 1;
        for (int j = first; j < last; ++j)
            if (j != i) weight *= p[j].y / (p[j].y - p[i].y);
        for (int k = 0; k < kValues; ++k) sum[k] += weight * p[i].value[k];
    }
    return sum;
}

// Slopes there of the cubic through all nodes.
std::array<double, kValues> slopes_at_zero(const Pack& p) {
    std::array<double, kValues> sum{};
    for (int i = 0; i < kNodes; ++i) {
        double weight = 0;
        for (int m = 0; m < kNodes; ++m) {
            if (m == i) continue;
            double part = 1 / (p[i].y - p[m].y);
            for (int j = 0; j < kNodes; ++j)
                if (j != i && j != m) part *= p[j].y / (p[j].y - p[i].y);
            weight += part;
        }
        for (int k = 0; k < kValues; ++k) sum[k] += weight * p[i].value[k];
    }
    return sum;
}

class Search {
  public:
    Search(const Robot& robot, const Ground& ground, const Gait& gait, const SpeedWish& wish,
           const SteadyOptions& options)
        : shape_(robot, ground, gait),
          wish_(wish),
          options_(options),
          guess_(std::log(gait.omega)),
          high_(std::min(std::log(std::min(wish.highest, 1e300)) + kStepBlind, guess_ + kFar)) {}

    AtSpeed run() {
        middle_ = guess_, spread_ = std::clamp(wish_.spread, kLeastSpread, kMostSpread);
        AtSpeed found;
        for (int i = 0; i < kMostPacks && solve(); ++i) {
            if (ends(found)) break;
            if (!(middle_ >= guess_ - kFar && middle_ <= high_)) break;
        }
        return found;
    }

  private:
    // Solve a pack of rates round the middle; false if one has no state.
    bool solve() {
        std::array<double, kNodes> omega;
        std::array<SteadyState, kNodes> state;
        for (int i = 0; i < kNodes; ++i) {
            pack_[i].x = middle_ + spread_ * (2.0 * i / (kNodes - 1) - 1);
            omega[i] = std::exp(pack_[i].x);
        }
        shape_.solve(omega.data(), kNodes, options_, state.data());
        const auto log = [](double value) { return std::log(std::max(value, 1e-300)); };
        for (int i = 0; i < kNodes; ++i) {
            const SteadyState& s = state[i];
            Node& node = pack_[i];
            node.error = s.speed_error / std::max(s.speed, 1e-300);
            if (!(s.converged || node.error <= kNearMiss * options_.rtol)) return false;
            node.y = log(s.speed) - log(wish_.speed);
            node.value = {node.x, log(s.power), log(s.abs_power), log(s.positive_power)};
        }
        return true;
    }

    // Take the answer from the pack, or set the next pack.
    bool ends(AtSpeed& found) {
        bool rises = true;
        for (int i = 0; i + 1 < kNodes; ++i) rises = rises && pack_[i].y < pack_[i + 1].y;
        const bool inside = pack_.front().y <= 0 && pack_.back().y >= 0;
        if (!rises || !inside) return step(inside), false;
        const auto cubic = at_zero(pack_, 0, kNodes);
        const int first = -pack_.front().y < pack_.back().y ? 0 : 1;
        const auto quadratic = at_zero(pack_, first, first + kNodes - 1);
        double apart = 0;
        for (int k = 0; k < kValues; ++k)
            apart = std::max(apart, std::fabs(cubic[k] - quadratic[k]));
        if (!(apart <= kAgree * options_.rtol) && spread_ > 1.5 * kLeastSpread) {
            middle_ = cubic[0];
            spread_ = std::clamp(3 * apart, kLeastSpread, 0.3 * spread_);
            return false;
        }
        double error = 0;
        for (const Node& node : pack_) error = std::max(error, node.error);
        found = {std::exp(cubic[0]),
                 std::exp(cubic[1]),
                 std::exp(cubic[2]),
                 std::exp(cubic[3]),
                 error,
                 slopes_at_zero(pack_),
                 true};
        return true;
    }

    // Go on from the end of the pack that is nearer to the speed, or where it rises through it.
    void step(bool inside) {
        if (inside) {
            int k = 0;
            while (k + 2 < kNodes && pack_[k + 1].y < 0) ++k;
            const double part = -pack_[k].y / (pack_[k + 1].y - pack_[k].y);
            const double width = pack_[k + 1].x - pack_[k].x;
            middle_ = pack_[k].x + width * std::clamp(part, 0.0, 1.0), spread_ = width / 2;
            return;
        }
        const bool below = pack_.back().y < 0;
        const Node& end = below ? pack_[kNodes - 1] : pack_[0];
        const Node& next = below ? pack_[kNodes - 2] : pack_[1];
        const double slope = (end.y - next.y) / (end.x - next.x);
        const double step =
            slope > kLeastSlope ? -end.y / slope : -std::copysign(kStepBlind, end.y);
        const double bounded = std::clamp(step, -kLargestStep, kLargestStep);
        middle_ = end.x + bounded;
        spread_ = std::clamp(0.3 * std::fabs(bounded), 4 * kLeastSpread, kMostSpread);
    }

    RatesOfShape shape_;
    SpeedWish wish_;
    SteadyOptions options_;
    double guess_, high_, middle_ = 0, spread_ = 0;
    Pack pack_;
};

// A shape with its ln cost, and what a speed's change does to it.
struct Shape {
    double swing = 0, lag = 0, value = 0, log_rate = 0, slope = 0;
    AtSpeed state;
};

// A quadratic c0 + c1 x + c2 y + c3 x^2 + c4 xy + c5 y^2 near values on the nine points
// (x, y) = (-1, -1), (-1, 0) ... (1, 1): least squares.
struct Quadratic {
    std::array<double, 6> c{};

    explicit Quadratic(const std::array<double, 9>& v) {
        double sum = 0, xx = 0, yy = 0;
        for (int i = 0; i < 9; ++i) {
            const double x = i / 3 - 1, y = i % 3 - 1;
            sum += v[i], c[1] += x * v[i] / 6, c[2] += y * v[i] / 6, c[4] += x * y * v[i] / 4;
            xx += x * x * v[i], yy += y * y * v[i];
        }
        c[3] = xx / 2 - sum / 3, c[5] = yy / 2 - sum / 3;
        c[0] = (5 * sum - 3 * xx - 3 * yy) / 9;
    }
    double operator()(double x, double y) const {
        return c[0] + x * (c[1] + c[3] * x + c[4] * y) + y * (c[2] + c[5] * y);
    }
    double det() const { return 4 * c[3] * c[5] - c[4] * c[4]; }
    bool convex() const { return c[3] > 0 && det() > 0; }
    // Where the gradient is (-a, -b).
    std::array<double, 2> solve(double a, double b) const {
        return {(c[4] * b - 2 * c[5] * a) / det(), (c[4] * a - 2 * c[3] * b) / det()};
    }
    // The lowest point of the box.
    std::array<double, 2> lowest() const {
        if (convex()) {
            const auto at = solve(c[1], c[2]);
            if (std::max(std::fabs(at[0]), std::fabs(at[1])) <= 1) return at;
        }
        std::array<double, 2> best{};
        const auto look = [&](double x, double y) {
            if ((*this)(x, y) < (*this)(best[0], best[1])) best = {x, y};
        };
        for (const double end : {-1.0, 1.0}) {
            look(end, -1), look(end, 1);
            if (c[5] > 0) look(end, std::clamp(-(c[2] + c[4] * end) / (2 * c[5]), -1.0, 1.0));
            if (c[3] > 0) look(std::clamp(-(c[1] + c[4] * end) / (2 * c[3]), -1.0, 1.0), end);
        }
        return best;
    }
};

// Boxes of nine shapes: to the lowest point of each one's quadratic model. A smooth function's
// model tells its minimum to the square of the box.
class Valley {
  public:
    Valley(const Robot& robot, const Ground& ground, const ValleyStart& start, int cost,
           const SpeedWish& wish, const SteadyOptions& options)
        : robot_(robot),
          ground_(ground),
          start_(start),
          cost_(cost),
          wish_(wish),
          options_(options) {}

    ValleyEnd run() {
        Shape best{start_.swing, start_.lag, 0, start_.log_rate, 0, {}};
        double radius = std::max(start_.radius, start_.smallest), smallest = start_.smallest;
        const double finest = smallest / kFiner;
        if (!solve(best, kStartSpread)) return end_;
        for (int i = 0; i < kMostBoxes; ++i) {
            Shape next;
            if (!box(best, radius, next)) return end_;
            const double step =
                std::max(std::fabs(next.swing - best.swing), std::fabs(next.lag - best.lag));
            best = next;
            if (step >= 0.5 * radius) continue;
            const bool last = radius <= smallest * (1 + 1e-9);
            if (end_.gap > kClose) smallest = std::max(kShrink * smallest, finest);
            if (last && radius <= smallest * (1 + 1e-9)) break;
            radius = std::min(kShrink * radius, std::max(kMissed * radius * radius, smallest));
            if (radius < smallest) break;
        }
        end_.swing = best.swing, end_.lag = best.lag, end_.state = best.state, end_.inside = true;
        return end_;
    }

  private:
    static constexpr double kShrink = 0.4, kFiner = 15;
    static constexpr double kMissed = 1.5;  // over radius^2: how far the minimum may be
    static constexpr double kClose = 3e-8;  // e-folds of cost: model and minimum agree
    static constexpr double kStartSpread = 0.05, kSpread = 0.003, kCurved = 0.3;  // e-folds of rate
    static constexpr int kMostBoxes = 60;

    bool solve(Shape& s, double spread) {
        const double beta = std::min(std::exp(s.lag), M_PI);
        const double alpha = 2 * std::exp(s.swing) * std::sin(beta / 2);
        if (!(alpha > 0 && alpha <= M_PI)) return false;
        SpeedWish wish = wish_;
        wish.spread = spread;
        ++end_.shapes;
        s.state = at_speed(robot_, ground_, {alpha, beta, std::exp(s.log_rate), 0}, wish, options_);
        if (!s.state.found) return false;
        const double watts[] = {s.state.power, s.state.abs_power, s.state.positive_power};
        s.value = std::log(std::max(watts[cost_], 1e-300));
        s.log_rate = std::log(s.state.omega), s.slope = s.state.slope[1 + cost_];
        return true;
    }

    // The lowest of the box round a shape, and of its model; false if that cannot be told.
    bool box(const Shape& middle, double radius, Shape& lowest) {
        std::array<Shape, 9> star;
        std::array<double, 9> value, rate, slope;
        for (int i = 0; i < 9; ++i) {
            const double x = radius * (i / 3 - 1), y = radius * (i % 3 - 1);
            star[i] = middle;
            if (i != 4) {
                star[i].swing += x, star[i].lag += y;
                star[i].log_rate += rate_slope_[0] * x + rate_slope_[1] * y;
                if (!within(star[i]) || !solve(star[i], kCurved * radius + kSpread)) return false;
            }
            value[i] = star[i].value, rate[i] = star[i].log_rate, slope[i] = star[i].slope;
        }
        const Quadratic costs(value), rates(rate), slopes(slope);
        rate_slope_ = {rates.c[1] / radius, rates.c[2] / radius};
        const auto [x, y] = costs.lowest();
        Shape next = middle;
        next.swing += radius * x, next.lag += radius * y;
        next.log_rate = rates(x, y);
        if (!within(next) || !solve(next, kSpread)) return false;
        lowest = next;
        for (const Shape& s : star)
            if (s.value < lowest.value) lowest = s;
        end_.gap = std::fabs(lowest.value - costs(x, y));
        const auto moves = costs.solve(slopes.c[1], slopes.c[2]);
        const bool known = costs.convex();
        for (int k = 0; k < 2; ++k) end_.tangent[k] = known ? radius * moves[k] : NAN;
        end_.tangent[2] = lowest.state.slope[0] + rate_slope_[0] * end_.tangent[0] +
                          rate_slope_[1] * end_.tangent[1];
        return true;
    }

    bool within(const Shape& s) const {
        return s.swing >= start_.low[0] && s.swing <= start_.high[0] && s.lag >= start_.low[1] &&
               s.lag <= start_.high[1];
    }

    const Robot& robot_;
    const Ground& ground_;
    ValleyStart start_;
    int cost_;
    SpeedWish wish_;
    SteadyOptions options_;
    ValleyEnd end_;
    std::array<double, 2> rate_slope_{-2, 0};  // creeping: speed goes as rate times swing squared
};

}  // namespace

AtSpeed at_speed(const Robot& robot, const Ground& ground, const Gait& gait, const SpeedWish& wish,
                 const SteadyOptions& options) {
    return Search(robot, ground, gait, wish, options).run();
}

ValleyEnd lowest_shape(const Robot& robot, const Ground& ground, const ValleyStart& start, int cost,
                       const SpeedWish& wish, const SteadyOptions& options) {
    return Valley(robot, ground, start, cost, wish, options).run();
}

}  // namespace serpenoid
