// Periodic state under viscous friction; the derivation stands in viscous.hpp.
#include "periodic/viscous.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "body/joint_power.hpp"
#include "numerics/matrix_product.hpp"
#include "periodic/positive_power.hpp"

namespace serpenoid {

namespace {

double rate(double L, double omega, double K, double J) { return (L - omega * K) / J; }

// Sums over the joints' elements. Between meshes the change of every joint in every element of the
// coarser one counts, so that no luck of signs hides one; a kink limits the gain of a finer mesh to
// some 2^6, and where it is lost among the nodes to much less.
void add_positive(const std::vector<double>& fine, const std::vector<double>& coarse,
                  SteadyState& out) {
    constexpr double kGain = 2;
    out.positive_power = out.positive_power_error = 0;
    const std::size_t ratio = coarse.empty() ? 1 : fine.size() / coarse.size();
    for (std::size_t i = 0; i < fine.size(); i += ratio) {
        double sum = 0;
        for (std::size_t k = i; k < i + ratio; ++k) sum += fine[k];
        out.positive_power += sum;
        if (!coarse.empty()) out.positive_power_error += std::fabs(sum - coarse[i / ratio]) / kGain;
    }
    out.abs_power = 2 * out.positive_power - out.power;
}

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

SteadyViscous::SteadyViscous(const Robot& robot, const Ground& ground, const Gait& gait)
    : robot_(robot),
      ground_(ground),
      gait_(gait),
      table_(robot.n, gait),
      mirrored_(gait.offset == 0) {
    for (int i = 0; i + 1 < robot.n; ++i) lag_.push_back(table_.lag(i));
}

SteadyViscous::Node SteadyViscous::node(double tau) const {
    Node k{};
    k.shape.set(robot_, table_, std::sin(tau), std::cos(tau), true);
    k.J = k.shape.J, k.K = k.shape.K;
    static_cast<ViscousSums&>(k) = ViscousSums(k.shape, ground_);
    return k;
}

const SteadyViscous::Mesh& SteadyViscous::mesh(int elements) {
    Mesh& m = meshes_[elements];
    if (!m.nodes.empty()) return m;
    m.elements = elements;
    m.h = (mirrored_ ? M_PI : 2 * M_PI) / elements;
    const Rule& rule = Rule::get();
    for (int e = 0; e < elements; ++e)
        for (int j = 0; j < kStages; ++j) m.nodes.push_back(node((e + rule.c[j]) * m.h));
    return m;
}

// f = dy/dtau and its Jacobian.
Vec3 SteadyViscous::derivative(const Node& k, const Vec3& y, double omega, Mat3& A) const {
    const double w = rate(y[2], omega, k.K, k.J), iJ = 1 / k.J, io = 1 / omega;
    const double inm = io / (robot_.n * robot_.m);
    const double gx = -(k.D[0] * y[0] + k.D[1] * y[1] + k.D[2] * w + omega * k.d[0]);
    const double gy = -(k.D[1] * y[0] + k.D[3] * y[1] + k.D[4] * w + omega * k.d[1]);
    const double gw = -(k.D[2] * y[0] + k.D[4] * y[1] + k.D[5] * w + omega * k.d[2]);
    A = {-k.D[0] * inm,          -k.D[1] * inm + w * io, (-k.D[2] * inm + y[1] * io) * iJ,
         -k.D[1] * inm - w * io, -k.D[3] * inm,          (-k.D[4] * inm - y[0] * io) * iJ,
         -k.D[2] * io,           -k.D[4] * io,           -k.D[5] * io * iJ};
    return {gx * inm + w * y[1] * io, gy * inm - w * y[0] * io, gw * io};
}

// Start from rest, or carry the last solution over: scaled to this rate, interpolated to this mesh.
void SteadyViscous::guess(const Mesh& m, double omega) {
    const int count = m.elements * kStages;
    if (now_.elements == 0) {
        now_ = {m.elements, omega, {}, std::vector<Vec3>(count, Vec3{})};
        for (int j = 0; j < count; ++j) now_.stage[j][2] = omega * m.nodes[j].K;  // w = 0
        return;
    }
    const double scale = omega / now_.omega;
    std::vector<Vec3> next(count);
    const Rule& rule = Rule::get();
    for (int e = 0; e < m.elements; ++e)
        for (int j = 0; j < kStages; ++j) {
            const double at = (e + rule.c[j]) * now_.elements / m.elements;
            const int old = std::min(static_cast<int>(at), now_.elements - 1);
            const auto weight = rule.lagrange(at - old);
            for (int k = 0; k < kStages; ++k)
                for (int i = 0; i < 3; ++i)
                    next[e * kStages + j][i] +=
                        scale * weight[k] * now_.stage[old * kStages + k][i];
        }
    for (double& v : now_.start) v *= scale;
    now_.stage = std::move(next), now_.elements = m.elements, now_.omega = omega;
}

// Linearise one element about its stages, begun at y, and eliminate them. On return y is the end.
bool SteadyViscous::eliminate(const Mesh& m, int e, double omega, Vec3& y, Element& out) const {
    constexpr int s = kStages, N = 3 * s;
    const Rule& rule = Rule::get();
    const Vec3* Y = &now_.stage[e * s];
    std::array<Mat3, s> jacobian;
    std::array<Vec3, s> f;
    std::array<double, N * N> A;
    for (int j = 0; j < s; ++j) f[j] = derivative(m.nodes[e * s + j], Y[j], omega, jacobian[j]);
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

// Add what an element's start moves by, and its own correction, to its stages. Returns the largest
// change and the largest value, both as speeds, m/s.
std::pair<double, double> SteadyViscous::update(const Mesh& m, int e, double omega,
                                                const Element& element, const Vec3& d) {
    double change = 0, size = 0;
    for (int j = 0; j < kStages; ++j) {
        Vec3 delta, &Y = now_.stage[e * kStages + j];
        for (int i = 0; i < 3; ++i) {
            const double* r = &element.stages[(3 * j + i) * 4];
            delta[i] = r[0] * d[0] + r[1] * d[1] + r[2] * d[2] + r[3];
            Y[i] += delta[i];
        }
        const Node& k = m.nodes[e * kStages + j];
        const double arm = std::sqrt(k.J / (robot_.n * robot_.m)) / k.J;  // L -> a speed, m/s
        change =
            std::max({change, std::fabs(delta[0]), std::fabs(delta[1]), arm * std::fabs(delta[2])});
        size = std::max({size, std::fabs(Y[0]), std::fabs(Y[1]),
                         arm * std::max(std::fabs(Y[2]), omega * std::fabs(k.K))});
    }
    return {change, size};
}

// One Newton step on all stages and the start. Returns the largest change, relative to the largest
// speed; sets `half` to the transfer matrix of the whole mesh. NaN when a system is singular.
double SteadyViscous::newton_step(const Mesh& m, double omega, Mat3& half) {
    std::vector<Element> elements(m.elements);
    Mat3 P = identity3();  // d(end)/d(start) of the mesh so far, and what it misses the end by
    Vec3 q{}, y = now_.start;
    for (int e = 0; e < m.elements; ++e) {
        Element& element = elements[e];
        if (!eliminate(m, e, omega, y, element)) return NAN;
        q = multiply(element.transfer, q);
        for (int i = 0; i < 3; ++i) q[i] += element.correction[i];
        P = multiply(element.transfer, P);
    }
    // closing: S (start + d) = y + P d + q  (S = 1 without the mirror)
    Mat3 C;
    Vec3 d;
    const double S[3] = {1, mirrored_ ? -1.0 : 1.0, mirrored_ ? -1.0 : 1.0};
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) C[3 * i + j] = (i == j) * S[i] - P[3 * i + j];
        d[i] = y[i] + q[i] - S[i] * now_.start[i];
    }
    half = P;
    if (!solve_dense<3, 1>(C.data(), d.data())) return NAN;
    for (int i = 0; i < 3; ++i) now_.start[i] += d[i];
    double change = 0, size = 0;
    for (int e = 0; e < m.elements; ++e) {
        const auto [moved, value] = update(m, e, omega, elements[e], d);
        change = std::max(change, moved), size = std::max(size, value);
        d = multiply(elements[e].transfer, d);
        for (int i = 0; i < 3; ++i) d[i] += elements[e].correction[i];
    }
    return size > 0 ? change / size : 0;
}

// Until the change is below `enough`: its square, about, is the error left.
bool SteadyViscous::newton(const Mesh& m, double omega, double enough, SteadyState& result) {
    constexpr int kMost = 40;
    Mat3 P;
    for (int i = 0; i < kMost; ++i) {
        const double change = newton_step(m, omega, P);
        ++result.iterations;
        if (!std::isfinite(change)) return false;
        if (change > enough) continue;
        if (mirrored_)
            for (int r = 3; r < 9; ++r) P[r] = -P[r];
        result.monodromy = mirrored_ ? multiply(P, P) : P;
        return true;
    }
    return false;
}

// Path over the mesh, in axes that turn by `spin` rad per rad of phase: displacement (x, y) and
// change of heading. Appended integrals, of the same order as the state.
Vec3 SteadyViscous::travel(const Mesh& m, double omega, double spin) const {
    constexpr int s = kStages;
    const Rule& rule = Rule::get();
    double theta = 0, x = 0, y = 0;
    for (int e = 0; e < m.elements; ++e) {
        std::array<double, s> w;
        for (int j = 0; j < s; ++j) {
            const Node& k = m.nodes[e * s + j];
            w[j] = rate(now_.stage[e * s + j][2], omega, k.K, k.J);
        }
        for (int j = 0; j < s; ++j) {
            const Vec3& Y = now_.stage[e * s + j];
            double angle = theta - spin * (e + rule.c[j]) * m.h;
            for (int i = 0; i < s; ++i) angle += m.h / omega * rule.a[j * s + i] * w[i];
            const double c = std::cos(angle), n = std::sin(angle), dt = m.h / omega * rule.b[j];
            x += dt * (c * Y[0] - n * Y[1]), y += dt * (n * Y[0] + c * Y[1]);
        }
        for (int j = 0; j < s; ++j) theta += m.h / omega * rule.b[j] * w[j];
    }
    return {x, y, theta};
}

// Speed, turn and dissipation.
void SteadyViscous::averages(const Mesh& m, double omega, SteadyState& out) const {
    constexpr int s = kStages;
    const Rule& rule = Rule::get();
    double energy = 0;
    for (int e = 0; e < m.elements; ++e)
        for (int j = 0; j < s; ++j) {
            const Node& k = m.nodes[e * s + j];
            const Vec3& Y = now_.stage[e * s + j];
            const double w = rate(Y[2], omega, k.K, k.J), *D = k.D;
            energy +=
                m.h / omega * rule.b[j] *
                (Y[0] * (D[0] * Y[0] + 2 * D[1] * Y[1] + 2 * D[2] * w) +
                 Y[1] * (D[3] * Y[1] + 2 * D[4] * w) + D[5] * w * w +
                 2 * omega * (k.d[0] * Y[0] + k.d[1] * Y[1] + k.d[2] * w) + omega * omega * k.dd);
        }
    const double span = 2 * M_PI / omega;
    out.power = energy / m.elements / m.h * omega;
    const Vec3 chord = travel(m, omega, 0);
    if (mirrored_) {  // the second half is the mirror image, seen from the heading then
        const double c = std::cos(chord[2]), n = std::sin(chord[2]);
        const double x = chord[0] + c * chord[0] + n * chord[1],
                     y = chord[1] + n * chord[0] - c * chord[1];
        out.speed = out.chord = std::hypot(x, y) / span;
        out.direction = std::atan2(y, x), out.turn = 0;
    } else {
        const Vec3 arc = travel(m, omega, chord[2] / (2 * M_PI));
        out.speed = std::hypot(arc[0], arc[1]) / span;
        out.chord = std::hypot(chord[0], chord[1]) / span;
        out.direction = std::atan2(arc[1], arc[0]), out.turn = chord[2];
    }
    const BodyShape shape = node(0).shape;
    const Vec3 start = beginning(m, omega);
    out.start = {start[0], start[1], rate(start[2], omega, shape.K, shape.J)};
}

// What every element has of the mean of P_i^+ of every joint, joint by joint. Torque and joint rate
// change sign at places of their own; that of the rate is known, phi_i' = 0 where tau + lag_i is an
// odd multiple of pi/2.
std::vector<double> SteadyViscous::positive_powers(const Mesh& m, double omega) const {
    constexpr int s = kStages;
    std::vector<std::array<double, s>> torque(robot_.n - 1), joint_rate(robot_.n - 1);
    std::vector<double> part((robot_.n - 1) * m.elements);
    for (int e = 0; e < m.elements; ++e) {
        for (int j = 0; j < s; ++j) {
            const Node& k = m.nodes[e * s + j];
            const Vec3& Y = now_.stage[e * s + j];
            const double u[3] = {Y[0], Y[1], rate(Y[2], omega, k.K, k.J)};
            double force[3];
            force[0] = -(k.D[0] * u[0] + k.D[1] * u[1] + k.D[2] * u[2] + omega * k.d[0]);
            force[1] = -(k.D[1] * u[0] + k.D[3] * u[1] + k.D[4] * u[2] + omega * k.d[1]);
            force[2] = -(k.D[2] * u[0] + k.D[4] * u[1] + k.D[5] * u[2] + omega * k.d[2]);
            const auto friction = [&](int i) {
                const LinkShape& link = k.shape.link[i];
                return std::pair{-ground_.ct * link.t.speed(u, omega),
                                 -ground_.cn * link.n.speed(u, omega)};
            };
            joint_powers(
                robot_, k.shape, omega, BodyMotion::from_forces(robot_, k.shape, omega, u, force),
                friction,
                [&](int i, double T, double v) { torque[i][j] = T, joint_rate[i][j] = v; });
        }
        for (int i = 0; i + 1 < robot_.n; ++i)
            part[i * m.elements + e] = mean_positive_swing<s>(torque[i], joint_rate[i], e * m.h,
                                                              m.h, lag_[i], gait_.alpha) /
                                       m.elements;
    }
    return part;
}

SteadyState SteadyViscous::solve(double omega, const SteadyOptions& options) {
    const Acceptance accepted(options, robot_, ground_, omega);
    SteadyState result, coarse;
    std::vector<double> positive;
    LevelChange before;
    int meshes = 0;
    const double enough = std::clamp(0.1 * std::sqrt(options.rtol), 1e-7, 1e-4);
    for (int elements = mirrored_ ? 2 : 4; elements <= options.max_elements; elements *= 2) {
        const Mesh& m = mesh(elements);
        guess(m, omega);
        result.elements = elements;
        if (!newton(m, omega, enough, result)) {
            now_.elements = 0;
            continue;
        }
        averages(m, omega, result);
        if (options.powers) {
            const std::vector<double> finer = positive_powers(m, omega);
            add_positive(finer, positive, result);
            positive = finer;
        }
        const LevelChange change(result, coarse);
        bound_errors(change, before, rule(change, before, meshes), options.rtol, result);
        result.converged = meshes > 0 && accepted(result);
        if (result.converged) break;
        ++meshes, before = change, coarse = result;
    }
    if (now_.elements > 0) bound_slowest(omega, options.rtol, coarse, result);
    return result;
}

// Gauss's rule has order 12, but meshes that are still coarse may show little of it: what a mesh
// has gained on the one before is what the next may be trusted with.
ErrorRule SteadyViscous::rule(const LevelChange& change, const LevelChange& before,
                              int meshes) const {
    constexpr double kMostGain = 16, kRounding = 2e-15;
    const double gain = meshes < 2 ? 1 : std::clamp(before.speed / change.speed, 1.0, kMostGain);
    return {1 / gain, 0, 0, kRounding * now_.omega * robot_.l * robot_.n};
}

// The last mesh but one is mostly too coarse for an order to be told.
void SteadyViscous::bound_slowest(double omega, double rtol, const SteadyState& coarse,
                                  SteadyState& s) {
    slowest(mesh(now_.elements), omega, s);
    if (s.slowest_error == 0)
        s.slowest_error =
            std::fabs(s.slowest -
                      (coarse.elements > 0 ? log_spectral_radius(coarse.monodromy) : 0)) +
            change_of(s.monodromy, coarse.monodromy) / 4;
    s.slowest_error += 0.1 * rtol * std::fabs(s.slowest);
}

}  // namespace serpenoid
