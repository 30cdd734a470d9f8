// Puts scenes into the memory of the vector kernels, takes states out, and runs batches of gaits.
#include "kernels/gait_batch.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <new>

#include "model/gait.hpp"

namespace serpenoid {

std::vector<const kernels::Set*> instruction_sets() {
    std::vector<const kernels::Set*> found;
#if defined(__x86_64__) || defined(__i386__)
    if (kernels::avx512.width && __builtin_cpu_supports("avx512f") &&
        __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512dq"))
        found.push_back(&kernels::avx512);
    if (kernels::avx2.width && __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
        found.push_back(&kernels::avx2);
#endif
    found.push_back(&kernels::baseline), found.push_back(&kernels::scalar);
    return found;
}

namespace {

kernels::Law law_of(const BatchScene& scene) {
    if (scene.ground.ratchet())
        return scene.smoothing > 0 ? kernels::Law::smoothed_ratchet : kernels::Law::ratchet;
    if (!scene.ground.dry()) return kernels::Law::viscous;
    return scene.smoothing > 0 ? kernels::Law::smoothed : kernels::Law::dry;
}

}  // namespace

void PackedRuns::Free::operator()(double* p) const { std::free(p); }

PackedRuns::PackedRuns(const BatchScene& scene, const std::vector<Gait>& gaits, bool batch,
                       const kernels::Set& set)
    : width_(set.width), batch_(batch) {
    const int n = scene.robot.n, rows = batch ? n : (n + width_ - 1) / width_;
    const std::size_t packs = kernels::kOnes + std::size_t{kernels::kRow} * rows;
    const std::size_t bytes = (packs * width_ * sizeof(double) + 63) / 64 * 64;
    memory_.reset(static_cast<double*>(std::aligned_alloc(64, bytes)));
    if (!memory_) throw std::bad_alloc();
    std::memset(memory_.get(), 0, bytes);
    const double never = std::numeric_limits<double>::quiet_NaN();
    task_ = {scene.robot, scene.ground, scene.smoothing, rows, memory_.get(), 0, never};
    const int law = static_cast<int>(law_of(scene));
    kernel_ = batch ? set.batch[law] : set.chain[law];
    for (int lane = 0; lane < (batch ? width_ : 1); ++lane) {
        for (int i = 1; i < n; ++i)
            at(kernels::kStiffness, i, lane) = scene.spring.k,
                                       at(kernels::kDamping, i, lane) = scene.spring.c;
        take_gait(lane, gaits[std::min<std::size_t>(lane, gaits.size() - 1)]);
    }
}

double& PackedRuns::at(int what, int link, int gait) const {
    const std::size_t row = batch_ ? link : link / width_, lane = batch_ ? gait : link % width_;
    return memory_[(kernels::kOnes + row * kernels::kRow + what) * width_ + lane];
}

double& PackedRuns::one(int which, int gait) const { return memory_[which * width_ + gait]; }

// theta_i - theta_1, the sum of the joint angles (Eq. 57) up to link i, and its sum over links.
void PackedRuns::take_gait(int lane, const Gait& gait) {
    const GaitTable table(task_.robot.n, gait);
    double a = 0, b = 0, sum_a = 0, sum_b = 0;
    for (int i = 0; i < task_.robot.n; ++i) {
        if (i > 0) {
            a += gait.alpha * table.cosine(i - 1);
            b += gait.alpha * table.sine(i - 1);
        }
        at(kernels::kAngleSin, i, lane) = a, at(kernels::kAngleCos, i, lane) = b;
        at(kernels::kAngleOffset, i, lane) = i * gait.offset;
        sum_a += a, sum_b += b;
    }
    for (int j = lane; j < (batch_ ? lane + 1 : width_); ++j) {
        one(kernels::kGaitOmega, j) = gait.omega;
        one(kernels::kTurnSin, j) = sum_a, one(kernels::kTurnCos, j) = sum_b;
    }
}

void PackedRuns::set(int gait, const double* y) {
    const int n = task_.robot.n;
    for (int part = 0; part < 4; ++part)
        for (int i = 0; i < n; ++i) at(kernels::kX + part, i, gait) = y[part * n + i];
    for (int j = gait; j < (batch_ ? gait + 1 : width_); ++j)
        one(kernels::kTheta, j) = y[4 * n], one(kernels::kOmega, j) = y[4 * n + 1];
}

void PackedRuns::get(int gait, double* y) const {
    const int n = task_.robot.n;
    for (int part = 0; part < 4; ++part)
        for (int i = 0; i < n; ++i) y[part * n + i] = at(kernels::kX + part, i, gait);
    y[4 * n] = one(kernels::kTheta, gait), y[4 * n + 1] = one(kernels::kOmega, gait);
}

namespace {

bool finite(const double* y, int dim) {
    return std::all_of(y, y + dim, [](double v) { return std::isfinite(v); });
}

// Up to `width` gaits at once; looks for lost ones every so many steps, and keeps what they were.
class GaitBlock {
  public:
    static constexpr long kLook = 64;

    GaitBlock(const BatchScene& scene, const std::vector<Gait>& gaits, bool batch,
              const kernels::Set& set)
        : task_(scene, gaits, batch, set),
          count_(static_cast<int>(gaits.size())),
          y_(task_.dim()) {}

    // `state` holds the starts and takes the ends.
    void run(double dt, double duration, long steps, double* state, double* reached) {
        for (int g = 0; g < count_; ++g) task_.set(g, state + g * task_.dim()), reached[g] = 0;
        alive_.assign(count_, true);
        if (steps == 0) return;
        for (long i = 0; i + 1 < steps; i += kLook) {
            const long count = std::min(kLook, steps - 1 - i);
            task_.advance(dt, i, count);
            if (!look(static_cast<double>(i + count) * dt, state, reached)) return;
        }
        task_.step(static_cast<double>(steps - 1) * dt, duration);
        look(duration, state, reached);
    }

  private:
    bool look(double t, double* state, double* reached) {
        bool any = false;
        for (int g = 0; g < count_; ++g) {
            if (!alive_[g]) continue;
            task_.get(g, y_.data());
            alive_[g] = finite(y_.data(), task_.dim());
            if (!alive_[g]) continue;
            std::copy(y_.begin(), y_.end(), state + g * task_.dim());
            reached[g] = t, any = true;
        }
        return any;
    }

    PackedRuns task_;
    int count_;
    std::vector<double> y_;
    std::vector<bool> alive_;
};

}  // namespace

GaitEnds run_gaits(const BatchScene& scene, const std::vector<Gait>& gaits,
                   const std::vector<double>& starts, double dt, double duration, long steps,
                   const kernels::Set& set, bool batch) {
    const std::size_t dim = 4 * scene.robot.n + 2, block = batch ? set.width : 1;
    GaitEnds ends{starts, std::vector<double>(gaits.size())};
    for (std::size_t g = 0; g < gaits.size(); g += block) {
        const std::size_t to = std::min(gaits.size(), g + block);
        GaitBlock(scene, {gaits.begin() + g, gaits.begin() + to}, batch, set)
            .run(dt, duration, steps, ends.state.data() + g * dim, ends.reached.data() + g);
    }
    return ends;
}

}  // namespace serpenoid
