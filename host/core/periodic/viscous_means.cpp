// Integrals of viscous_means.hpp: appended to the collocation, of the same order as the state.
#include "periodic/viscous_means.hpp"

#include <array>
#include <cmath>
#include <utility>

#include "body/joint_power.hpp"
#include "model/friction_law.hpp"
#include "periodic/cycle_map.hpp"
#include "periodic/positive_power.hpp"

namespace serpenoid {

namespace {

constexpr int s = ViscousMesh::kStages;

// Path over the mesh, in axes that turn by `spin` rad per rad of phase.
Path travel(const ViscousMotion& motion, double spin) {
    const ViscousMesh& m = *motion.mesh;
    const auto& rule = ViscousMesh::Rule::get();
    const double unit = m.h / motion.omega;
    Path path{0, 0, 0};
    for (int e = 0; e < m.elements; ++e) {
        std::array<double, s> w;
        for (int j = 0; j < s; ++j)
            w[j] = ViscousShape::velocity(m.nodes[e * s + j], motion.stage[e * s + j],
                                          motion.omega)[2];
        for (int j = 0; j < s; ++j) {
            const Vec3& Y = motion.stage[e * s + j];
            double angle = path.turn - spin * (e + rule.c[j]) * m.h;
            for (int i = 0; i < s; ++i) angle += unit * rule.a[j * s + i] * w[i];
            const double c = std::cos(angle), n = std::sin(angle), dt = unit * rule.b[j];
            path.x += dt * (c * Y[0] - n * Y[1]), path.y += dt * (n * Y[0] + c * Y[1]);
        }
        for (int j = 0; j < s; ++j) path.turn += unit * rule.b[j] * w[j];
    }
    return path;
}

}  // namespace

void set_means(const ViscousShape& shape, const ViscousMotion& motion, SteadyState& out) {
    const ViscousMesh& m = *motion.mesh;
    const auto& rule = ViscousMesh::Rule::get();
    const double omega = motion.omega, period = 2 * M_PI / omega;
    out.power = 0;
    for (int e = 0; e < m.elements; ++e)
        for (int j = 0; j < s; ++j) {
            const ViscousNode& k = m.nodes[e * s + j];
            const Vec3 u = ViscousShape::velocity(k, motion.stage[e * s + j], omega);
            out.power += rule.b[j] / m.elements * k.dissipation(u, omega);
        }
    Path path = travel(motion, 0);
    out.turn = shape.mirrored ? 0 : path.turn;
    if (shape.mirrored) path = path.twice_mirrored();
    out.chord = path.length() / period;
    if (!shape.mirrored) path = travel(motion, out.turn / (2 * M_PI));
    out.speed = path.length() / period, out.direction = path.direction();
}

// Torque and joint rate change sign at places of their own; that of the rate is known, phi_i' = 0
// where tau + lag_i is an odd multiple of pi/2.
std::vector<double> positive_powers(const ViscousShape& shape, const ViscousMotion& motion) {
    const ViscousMesh& m = *motion.mesh;
    const Robot& robot = shape.robot;
    const double omega = motion.omega;
    const WheelLaw along = WheelLaw::along(shape.ground), across = WheelLaw::across(shape.ground);
    std::vector<std::array<double, s>> torque(robot.n - 1), joint_rate(robot.n - 1);
    std::vector<double> part((robot.n - 1) * m.elements);
    for (int e = 0; e < m.elements; ++e) {
        for (int j = 0; j < s; ++j) {
            const ViscousNode& k = m.nodes[e * s + j];
            const Vec3 u = ViscousShape::velocity(k, motion.stage[e * s + j], omega),
                       drag = k.drag(u, omega), force = {-drag[0], -drag[1], -drag[2]};
            const auto friction = [&](int i) {
                const LinkShape& link = k.shape.link[i];
                return std::pair{along.force(link.t.speed(u.data(), omega), 0),
                                 across.force(link.n.speed(u.data(), omega), 0)};
            };
            joint_powers(
                robot, k.shape, omega,
                BodyMotion::from_forces(robot, k.shape, omega, u.data(), force.data()), friction,
                [&](int i, double T, double v) { torque[i][j] = T, joint_rate[i][j] = v; });
        }
        for (int i = 0; i + 1 < robot.n; ++i)
            part[i * m.elements + e] =
                mean_positive_swing<s>(torque[i], joint_rate[i], e * m.h, m.h, shape.table.lag(i),
                                       shape.gait.alpha) /
                m.elements;
    }
    return part;
}

// The error is the sum of the changes of each joint in each element of the coarser mesh, without
// their signs. A kink limits the gain of a finer mesh to some 2^6, and a kink between close nodes
// to much less.
void set_positive(const std::vector<double>& fine, const std::vector<double>& coarse,
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

}  // namespace serpenoid
