// Periodic state under viscous friction; the derivation stands in viscous.hpp.
#include "periodic/viscous.hpp"

#include <algorithm>
#include <cmath>

#include "numerics/matrix_product.hpp"
#include "periodic/cycle_map.hpp"
#include "periodic/viscous_decay.hpp"
#include "periodic/viscous_means.hpp"

namespace serpenoid {

namespace {

// Of a map's part that is of speeds alone, relative.
double change_of(const Mat3& fine, const Mat3& coarse) {
    double moved = 0, large = 0;
    for (const int i : {0, 1, 3, 4}) {
        moved = std::max(moved, std::fabs(fine[i] - coarse[i]));
        large = std::max(large, std::fabs(fine[i]));
    }
    return large > 0 ? moved / large : 0;
}

}  // namespace

// Start from rest, or carry the last solution over: scaled to this rate, interpolated to this mesh.
void SteadyViscous::guess(const ViscousMesh& m, double omega) {
    const int count = m.elements * kStages;
    if (!now_.mesh) {
        now_ = {&m, omega, {}, std::vector<Vec3>(count, Vec3{})};
        for (int j = 0; j < count; ++j) now_.stage[j][2] = omega * m.nodes[j].K;  // w = 0
        return;
    }
    const double scale = omega / now_.omega;
    std::vector<Vec3> next(count);
    const Rule& rule = Rule::get();
    for (int e = 0; e < m.elements; ++e)
        for (int j = 0; j < kStages; ++j) {
            const double at = (e + rule.c[j]) * now_.mesh->elements / m.elements;
            const int old = std::min(static_cast<int>(at), now_.mesh->elements - 1);
            next[e * kStages + j] = now_.between(old, at - old);
            for (double& v : next[e * kStages + j]) v *= scale;
        }
    for (double& v : now_.start) v *= scale;
    now_.stage = std::move(next), now_.mesh = &m, now_.omega = omega;
}

// Linearise one element about its stages, begun at y, and eliminate them. On return y is the end.
bool SteadyViscous::eliminate(int e, Vec3& y, Element& out) const {
    const ViscousMesh& m = *now_.mesh;
    constexpr int s = kStages, N = 3 * s;
    const Rule& rule = Rule::get();
    const Vec3* Y = &now_.stage[e * s];
    std::array<Mat3, s> jacobian;
    std::array<Vec3, s> f;
    std::array<double, N * N> A;
    for (int j = 0; j < s; ++j)
        f[j] = shape_.derivative(m.nodes[e * s + j], Y[j], now_.omega, jacobian[j]);
    for (int j = 0; j < s; ++j)
        for (int i = 0; i < 3; ++i) {
            double* row = &A[(3 * j + i) * N];
            double residual = y[i] - Y[j][i];
            for (int k = 0; k < s; ++k) {
                const double ha = m.h * rule.a[j * s + k];
                residual += ha * f[k][i];
                for (int c = 0; c < 3; ++c) row[3 * k + c] = -ha * jacobian[k][3 * i + c];
            }
            row[3 * j + i] += 1;
            double* r = &out.stages[(3 * j + i) * 4];
            r[0] = i == 0, r[1] = i == 1, r[2] = i == 2, r[3] = residual;
        }
    if (!solve_dense<N, 4>(A.data(), out.stages.data())) return false;
    out.transfer = identity3(), out.correction = {};
    for (int k = 0; k < s; ++k)
        for (int i = 0; i < 3; ++i) {
            y[i] += m.h * rule.b[k] * f[k][i];
            for (int c = 0; c < 3; ++c) {
                const double g = m.h * rule.b[k] * jacobian[k][3 * i + c];
                const double* r = &out.stages[(3 * k + c) * 4];
                for (int t = 0; t < 3; ++t) out.transfer[3 * i + t] += g * r[t];
                out.correction[i] += g * r[3];
            }
        }
    return true;
}

// Add the effect of the start's change, and the correction, to the stages. Returns the largest
// change and the largest value, both as speeds, m/s.
std::pair<double, double> SteadyViscous::update(int e, const Element& element, const Vec3& d) {
    const double nm = shape_.robot.n * shape_.robot.m;
    double change = 0, size = 0;
    for (int j = 0; j < kStages; ++j) {
        Vec3 delta, &Y = now_.stage[e * kStages + j];
        for (int i = 0; i < 3; ++i) {
            const double* r = &element.stages[(3 * j + i) * 4];
            delta[i] = r[0] * d[0] + r[1] * d[1] + r[2] * d[2] + r[3];
            Y[i] += delta[i];
        }
        const ViscousNode& k = now_.mesh->nodes[e * kStages + j];
        const double arm = std::sqrt(k.J / (nm)) / k.J;  // L -> a speed, m/s
        change =
            std::max({change, std::fabs(delta[0]), std::fabs(delta[1]), arm * std::fabs(delta[2])});
        size = std::max({size, std::fabs(Y[0]), std::fabs(Y[1]),
                         arm * std::max(std::fabs(Y[2]), now_.omega * std::fabs(k.K))});
    }
    return {change, size};
}

// Eliminate all elements, one after the other: `end` is what the linearised motion comes to.
bool SteadyViscous::linearise(Chain& chain) const {
    const int count = now_.mesh->elements;
    chain.elements.resize(count);
    Vec3 q{}, y = now_.start;
    for (int e = 0; e < count; ++e) {
        Element& element = chain.elements[e];
        if (!eliminate(e, y, element)) return false;
        q = multiply(element.transfer, q);
        for (int i = 0; i < 3; ++i) q[i] += element.correction[i];
        chain.transfer = multiply(element.transfer, chain.transfer);
    }
    for (int i = 0; i < 3; ++i) chain.end[i] = y[i] + q[i];
    return true;
}

// Move all stages by a change d of the start. Returns the largest change relative to the largest
// speed.
double SteadyViscous::update_all(const Chain& chain, Vec3 d) {
    double change = 0, size = 0;
    for (int e = 0; e < now_.mesh->elements; ++e) {
        const Element& element = chain.elements[e];
        const auto [moved, value] = update(e, element, d);
        change = std::max(change, moved), size = std::max(size, value);
        d = multiply(element.transfer, d);
        for (int i = 0; i < 3; ++i) d[i] += element.correction[i];
    }
    return size > 0 ? change / size : 0;
}

// Newton's method on all stages and the start, until the change is below `enough`. Returns the
// error left, relative: the square of the last change, as often as the cycle's memory repeats it.
// Infinite when a system is singular or the changes do not shrink.
double SteadyViscous::newton(double enough, SteadyState& result) {
    constexpr int kMost = 40;
    const bool mirrored = shape_.mirrored;
    const Vec3 S = mirror_signs(mirrored);
    for (int i = 0; i < kMost; ++i) {
        Chain chain;
        ++result.iterations;
        if (!linearise(chain)) return HUGE_VAL;
        Vec3 miss, d;
        for (int k = 0; k < 3; ++k) miss[k] = chain.end[k] - S[k] * now_.start[k];
        if (!close_cycle(chain.transfer, mirrored, miss, d)) return HUGE_VAL;
        for (int k = 0; k < 3; ++k) now_.start[k] += d[k];
        const double change = update_all(chain, d);
        if (!std::isfinite(change)) return HUGE_VAL;
        if (change > enough) continue;
        const Mat3 image = mirror_rows(chain.transfer, mirrored);
        result.monodromy = mirrored ? multiply(image, image) : image;
        const double decay = -std::expm1(log_spectral_radius(image));
        return change * change / std::max(decay, 1e-16);
    }
    return HUGE_VAL;
}

void SteadyViscous::set_means(SteadyState& out) const {
    serpenoid::set_means(shape_, now_, out);
    out.start = ViscousShape::velocity(shape_.node(0), state_at_start(shape_, now_), now_.omega);
}

SteadyState SteadyViscous::solve(double omega, const SteadyOptions& options) {
    const Acceptance accepted(options, shape_.robot, shape_.ground, omega);
    SteadyState result, coarse;
    std::vector<double> positive;
    LevelChange before;
    int meshes = 0;
    const double enough = std::clamp(0.1 * std::sqrt(options.rtol), 1e-7, 1e-4);
    for (int elements = shape_.mirrored ? 2 : 4; elements <= options.max_elements; elements *= 2) {
        guess(shape_.mesh(elements), omega);
        result.elements = elements;
        const double left = newton(enough, result);
        if (!std::isfinite(left)) {
            now_.mesh = nullptr;
            continue;
        }
        set_means(result);
        if (options.powers) {
            const std::vector<double> finer = positive_powers(shape_, now_);
            set_positive(finer, positive, result);
            positive = finer;
        }
        const LevelChange change(result, coarse);
        bound_errors(change, before, rule(change, before, meshes, left * result.speed),
                     options.rtol, result);
        result.converged = meshes > 0 && accepted(result);
        if (result.converged) break;
        ++meshes, before = change, coarse = result;
    }
    if (now_.mesh) set_slowest(options.rtol, coarse, result);
    return result;
}

// Gauss's rule has order 12, but coarse meshes may show little of it. The next mesh is assumed to
// gain as much as this one has gained.
ErrorRule SteadyViscous::rule(const LevelChange& change, const LevelChange& before, int meshes,
                              double left) const {
    constexpr double kMostGain = 16, kRounding = 2e-15;
    const double gain = meshes < 2 ? 1 : std::clamp(before.speed / change.speed, 1.0, kMostGain);
    return {1 / gain, 0, 0, left + kRounding * now_.omega * shape_.robot.l * shape_.robot.n};
}

// The last mesh but one is mostly too coarse to estimate an order.
void SteadyViscous::set_slowest(double rtol, const SteadyState& coarse, SteadyState& s) const {
    const Slowest found = slowest_multiplier(shape_, now_, s.monodromy);
    s.slowest = found.log_size, s.slowest_error = found.error;
    const Mat3 collocated = s.monodromy;
    s.monodromy = found.monodromy;
    if (found.error == 0) {
        const double before = coarse.elements > 0 ? log_spectral_radius(coarse.monodromy) : 0;
        s.slowest_error =
            std::fabs(s.slowest - before) + change_of(collocated, coarse.monodromy) / 4;
    }
    s.slowest_error += 0.1 * rtol * std::fabs(s.slowest);
}

}  // namespace serpenoid
