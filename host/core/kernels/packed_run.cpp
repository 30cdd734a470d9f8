// Puts a scene into the memory of the vector kernels and takes states out.
#include "kernels/packed_run.hpp"

#include <algorithm>
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

kernels::Law law_of(const Ground& ground, double smoothing) {
    if (ground.ratchet())
        return smoothing > 0 ? kernels::Law::smoothed_ratchet : kernels::Law::ratchet;
    if (!ground.dry()) return kernels::Law::viscous;
    return smoothing > 0 ? kernels::Law::smoothed : kernels::Law::dry;
}

}  // namespace

void PackedRun::Free::operator()(double* p) const { std::free(p); }

PackedRun::PackedRun(const Robot& robot, const Ground& ground, const JointSpring& spring,
                     const Slope& slope, double smoothing, const Gait& gait,
                     const kernels::Set& set)
    : step_(set.step[slope.tilted()][static_cast<int>(law_of(ground, smoothing))]),
      width_(set.width) {
    const int rows = (robot.n + width_ - 1) / width_;
    const std::size_t packs = kernels::kOnes + std::size_t{kernels::kRow} * rows;
    const std::size_t bytes = (packs * width_ * sizeof(double) + 63) / 64 * 64;
    memory_.reset(static_cast<double*>(std::aligned_alloc(64, bytes)));
    if (!memory_) throw std::bad_alloc();
    std::memset(memory_.get(), 0, bytes);
    const double never = std::numeric_limits<double>::quiet_NaN();
    task_ = {robot, ground, slope, smoothing, rows, memory_.get(), 0, never};
    for (int i = 1; i < robot.n; ++i)
        at(kernels::kStiffness, i) = spring.k, at(kernels::kDamping, i) = spring.c;
    take_gait(gait);
}

double& PackedRun::at(int what, int link) const {
    return memory_[(kernels::kOnes + link / width_ * kernels::kRow + what) * width_ +
                   link % width_];
}

void PackedRun::set_all_lanes(int which, double value) const {
    std::fill_n(&memory_[which * width_], width_, value);
}

// theta_i - theta_1, the sum of the joint angles (Eq. 57) up to link i, and its sum over links.
void PackedRun::take_gait(const Gait& gait) {
    const GaitTable table(task_.robot.n, gait);
    double a = 0, b = 0, sum_a = 0, sum_b = 0;
    for (int i = 0; i < task_.robot.n; ++i) {
        if (i > 0) {
            a += gait.alpha * table.cosine(i - 1);
            b += gait.alpha * table.sine(i - 1);
        }
        at(kernels::kAngleSin, i) = a, at(kernels::kAngleCos, i) = b;
        at(kernels::kAngleOffset, i) = i * gait.offset;
        sum_a += a, sum_b += b;
    }
    set_all_lanes(kernels::kGaitOmega, gait.omega);
    set_all_lanes(kernels::kTurnSin, sum_a), set_all_lanes(kernels::kTurnCos, sum_b);
}

void PackedRun::set(const double* y) {
    const int n = task_.robot.n;
    for (int part = 0; part < 4; ++part)
        for (int i = 0; i < n; ++i) at(kernels::kX + part, i) = y[part * n + i];
    set_all_lanes(kernels::kTheta, y[4 * n]), set_all_lanes(kernels::kOmega, y[4 * n + 1]);
}

void PackedRun::get(double* y) const {
    const int n = task_.robot.n;
    for (int part = 0; part < 4; ++part)
        for (int i = 0; i < n; ++i) y[part * n + i] = at(kernels::kX + part, i);
    y[4 * n] = memory_[kernels::kTheta * width_], y[4 * n + 1] = memory_[kernels::kOmega * width_];
}

}  // namespace serpenoid
