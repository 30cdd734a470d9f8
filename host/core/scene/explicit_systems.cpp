// The exact model as first-order systems, one for each way to drive the joints.
#include <algorithm>
#include <memory>

#include "drive/joint_angles.hpp"
#include "model/explicit_model.hpp"
#include "scene/make_system.hpp"
#include "scene/paired_system.hpp"
#include "scene/terms.hpp"

namespace serpenoid {

namespace {

// All angles imposed. State: x, y, theta of link 1, then their rates.
class ExplicitAngle final : public PairedSystem {
  public:
    explicit ExplicitAngle(const RunRequest& q)
        : PairedSystem(q.robot.n, 3),
          robot(q.robot),
          drive(q.robot.n, q.gait),
          force(ground_force(q)) {}

    void set(const Chain& c, double* y) const override {
        const double from[6] = {c.x[0], c.y[0], c.theta[0], c.vx[0], c.vy[0], c.omega[0]};
        std::copy_n(from, 6, y);
    }
    void fill(double t, const double* y) override {
        drive.place(t, y[2], y[5], chain);
        chain.x[0] = y[0], chain.y[0] = y[1], chain.vx[0] = y[3], chain.vy[0] = y[4];
        chain.follow(robot.l);
    }
    void load(double t, const double* y) override {
        fill(t, y);
        force(chain);
    }
    void accelerate() override { explicit_angle(robot, drive.joint_accel(), chain); }
    void recover() override { joint_forces(robot, chain, joints); }
    void rate(double t, const double* y, double* dy) override {
        load(t, y);
        const TailMotion tail = tail_motion(robot, drive.joint_accel(), chain);
        std::copy_n(y + 3, 3, dy);
        dy[3] = tail.ax;
        dy[4] = tail.ay;
        dy[5] = tail.alpha;
    }
    void derivative(const double* y, double* dy) const override {
        std::copy_n(y + 3, 3, dy);
        dy[3] = chain.ax[0], dy[4] = chain.ay[0], dy[5] = chain.alpha[0];
    }

  private:
    Robot robot;
    GaitDrive drive;
    GroundForce force;
};

// Some angles imposed, some torques given, or all of one kind. State: x, y, theta of link 1, the
// free joints' angles, then the rates of all these.
class ExplicitMixed final : public PairedSystem {
  public:
    ExplicitMixed(const RunRequest& q, MixedDrive joint_drive,
                  std::unique_ptr<TorqueSource> torques)
        : PairedSystem(q.robot.n, 3 + joint_drive.free_joints()),
          robot(q.robot),
          force(ground_force(q)),
          drive(std::move(joint_drive)),
          source(std::move(torques)) {}

    void set(const Chain& c, double* y) const override {
        const double from[3] = {c.x[0], c.y[0], c.theta[0]};
        const double rates[3] = {c.vx[0], c.vy[0], c.omega[0]};
        std::copy_n(from, 3, y), std::copy_n(rates, 3, y + half);
        for (int f = 0; f < drive.free_joints(); ++f) {
            const int i = drive.free()[f];
            y[3 + f] = c.theta[i + 1] - c.theta[i];
            y[half + 3 + f] = c.omega[i + 1] - c.omega[i];
        }
    }
    void fill(double t, const double* y) override {
        drive.place(t, y[2], y[half + 2], y + 3, y + half + 3, chain);
        chain.x[0] = y[0], chain.y[0] = y[1], chain.vx[0] = y[half], chain.vy[0] = y[half + 1];
        chain.follow(robot.l);
    }
    void load(double t, const double* y) override {
        fill(t, y);
        force(chain);
        source->torques(t, chain, driven.data());
        drive.limp(driven.data());
    }
    void accelerate() override {
        joints.T = driven;
        explicit_mixed(robot, drive.imposed(), drive.rotor(), drive.joint_accel(), chain, joints);
    }
    void rate(double t, const double* y, double* dy) override { forces(t, y), derivative(y, dy); }
    void derivative(const double* y, double* dy) const override {
        std::copy_n(y + half, half, dy);
        dy[half] = chain.ax[0], dy[half + 1] = chain.ay[0], dy[half + 2] = chain.alpha[0];
        for (int f = 0; f < drive.free_joints(); ++f) {
            const int i = drive.free()[f];
            dy[half + 3 + f] = chain.alpha[i + 1] - chain.alpha[i];
        }
    }
    bool rate_fills_forces() const override { return true; }
    double next_jump(double t) const override { return source->next_jump(t); }
    void enter(double t, const double* y) override { fill(t, y), source->enter(t, chain); }

  private:
    Robot robot;
    GroundForce force;
    MixedDrive drive;
    std::unique_ptr<TorqueSource> source;
};

}  // namespace

std::unique_ptr<PairedSystem> make_paired(const RunRequest& q) {
    if (mixed(q)) return std::make_unique<ExplicitMixed>(q, mixed_drive(q), make_torques(q));
    return std::make_unique<ExplicitAngle>(q);
}

std::unique_ptr<System> make_explicit(const RunRequest& q) { return make_paired(q); }

}  // namespace serpenoid
