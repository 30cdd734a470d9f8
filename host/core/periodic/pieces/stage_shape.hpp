// The chain at up to eight phases side by side, by packs: the inner loops of sliding_piece.hpp.
#pragma once

#include <array>
#include <utility>
#include <vector>

#include "body/body_shape.hpp"
#include "body/joint_power.hpp"
#include "body/viscous_drag.hpp"
#include "numerics/pack.hpp"

namespace serpenoid {

struct alignas(8 * kPack) Lanes {
    static constexpr int kCount = 8;
    double value[kCount];
    Pack& pack(int p) { return pack_at(value + p); }
    const Pack& pack(int p) const { return pack_at(value + p); }
};

// What is summed over the chain at one phase: viscous friction and the dry forces. The dry ones
// are -dry in the body frame, and dissipate dry . u + omega dry_e.
struct StageSums : ViscousSums {
    Vec3 dry;
    double dry_e;
};

class StageShape {
  public:
    StageShape(const Robot& robot, const Gait& gait)
        : robot_(robot), omega_(gait.omega), table_(robot.n, gait), friction_(2 * robot.n) {}

    // Place the chain at so many phases; the rest of the last pack is filled, too.
    void set(int lanes, const Lanes& tau) {
        for (int p = 0; p < lanes; p += kPack) set(shape_[p / kPack], tau.pack(p), false);
    }
    double J(int lane) const { return shape_[lane / kPack].J[lane % kPack]; }
    double K(int lane) const { return shape_[lane / kPack].K[lane % kPack]; }
    // Wheel 2i along link i or 2i + 1 across it.
    WheelDirection row(int wheel, int lane) const {
        const auto& g = direction(shape_[lane / kPack], wheel);
        const int j = lane % kPack;
        return {g.x[j], g.y[j], g.r[j], g.e[j]};
    }

    // The sums at a pack of phases, by every wheel's viscous coefficient and dry force.
    void sums(int pack, const double* viscous, const double* dry,
              StageSums* const (&lanes)[kPack]) {
        ViscousSumsOf<Pack> sum;
        DirectionOf<Pack> f{};
        for (int i = 0; i < 2 * robot_.n; ++i) {
            const auto& g = direction(shape_[pack], i);
            sum.add(g, viscous[i]);
            f.x += dry[i] * g.x;
            f.y += dry[i] * g.y;
            f.r += dry[i] * g.r;
            f.e += dry[i] * g.e;
        }
        for (int j = 0; j < kPack; ++j) {
            for (int k = 0; k < 6; ++k) lanes[j]->D[k] = sum.D[k][j];
            for (int k = 0; k < 3; ++k) lanes[j]->d[k] = sum.d[k][j];
            lanes[j]->dd = sum.dd[j];
            lanes[j]->dry = {f.x[j], f.y[j], f.r[j]};
            lanes[j]->dry_e = f.e[j];
        }
    }

    // Every wheel's speed at u = (Vx, Vy, w).
    void speeds(int lanes, const Lanes* u, Lanes* wheel_speeds) const {
        for (int p = 0; p < lanes; p += kPack) {
            const Pack v[3] = {u[0].pack(p), u[1].pack(p), u[2].pack(p)};
            for (int i = 0; i < 2 * robot_.n; ++i)
                wheel_speeds[i].pack(p) = direction(shape_[p / kPack], i).speed(v, omega_);
        }
    }

    // Every joint's torque and rate at such phases and n m Vx, n m Vy, L, by the wheels'
    // coefficients and dry forces.
    void torques(int lanes, const Lanes& tau, const Lanes* momenta, const double* viscous,
                 const Lanes* dry, Lanes* torque, Lanes* rate) {
        const double im = 1 / (robot_.n * robot_.m);
        for (int p = 0; p < lanes; p += kPack) {
            set(scratch_shape_, tau.pack(p), true);
            const Pack u[3] = {momenta[0].pack(p) * im, momenta[1].pack(p) * im,
                               (momenta[2].pack(p) - omega_ * scratch_shape_.K) / scratch_shape_.J};
            Pack force[3] = {};
            for (int i = 0; i < 2 * robot_.n; ++i) {
                const auto& g = direction(scratch_shape_, i);
                const Pack f = -dry[i].pack(p) - viscous[i] * g.speed(u, omega_);
                friction_[i] = f;
                force[0] += f * g.x;
                force[1] += f * g.y;
                force[2] += f * g.r;
            }
            joint_powers(
                robot_, scratch_shape_, omega_,
                BodyMotionOf<Pack>::from_forces(robot_, scratch_shape_, omega_, u, force),
                [&](int i) { return std::pair(friction_[2 * i], friction_[2 * i + 1]); },
                [&](int i, Pack T, Pack v) {
                    torque[i].pack(p) = T;
                    rate[i].pack(p) = v;
                });
        }
    }

  private:
    void set(BodyShapeOf<Pack>& shape, Pack tau, bool second) {
        Pack sine, cosine;
        sincos(tau, sine, cosine);
        shape.set(robot_, table_, sine, cosine, second);
    }
    static const DirectionOf<Pack>& direction(const BodyShapeOf<Pack>& shape, int wheel) {
        const auto& link = shape.link[wheel / 2];
        return wheel % 2 ? link.n : link.t;
    }

    Robot robot_;
    double omega_;
    GaitTable table_;
    std::array<BodyShapeOf<Pack>, Lanes::kCount / kPack> shape_;
    BodyShapeOf<Pack> scratch_shape_;
    std::vector<Pack> friction_;
};

}  // namespace serpenoid
