// Mechanics of the explicit model: one class for imposed angles, one for all other drives.
#include <algorithm>

#include "model/explicit_model.hpp"
#include "scene/mechanics.hpp"

namespace serpenoid {

namespace {

// All joint angles are imposed. Coordinates: x, y, theta of link 1.
class ExplicitAngle final : public Mechanics {
  public:
    ExplicitAngle(const RunRequest& request, const Ground& ground)
        : Mechanics(request, ground, 2, 1), drive(request.robot.n, request.gait) {}

    void write_state(const Chain& c, double* y) const override {
        const double state[6] = {c.x[0], c.y[0], c.theta[0], c.vx[0], c.vy[0], c.omega[0]};
        std::copy_n(state, 6, y);
    }
    void fill_chain(double t, const double* y) override {
        drive.place(t, y[2], y[5], chain);
        chain.x[0] = y[0];
        chain.y[0] = y[1];
        chain.vx[0] = y[3];
        chain.vy[0] = y[4];
        chain.follow(robot.l);
    }
    void load(double t, const double* y) override {
        fill_chain(t, y);
        chain.apply_ground(ground, robot.m * slope.gx, robot.m * slope.gy);
    }
    void accelerate() override { explicit_angle(robot, drive.joint_accel(), chain); }
    void find_joint_forces() override { joint_forces(robot, chain, joints); }
    void rate(double t, const double* y, double* dy) override {
        load(t, y);
        const TailMotion tail = tail_motion(robot, drive.joint_accel(), chain);
        std::copy_n(y + 3, 3, dy);
        dy[3] = tail.ax;
        dy[4] = tail.ay;
        dy[5] = tail.alpha;
    }
    bool rate_fills_forces() const override { return false; }
    void derivative(const double* y, double* dy) const override {
        std::copy_n(y + 3, 3, dy);
        dy[3] = chain.ax[0];
        dy[4] = chain.ay[0];
        dy[5] = chain.alpha[0];
    }

  private:
    GaitDrive drive;
};

// Some joints have an imposed angle, the others a torque; there may be only one of these kinds.
// Coordinates: x, y, theta of link 1, the angles of the joints with a torque.
class ExplicitMixed final : public Mechanics {
  public:
    ExplicitMixed(const RunRequest& request, const Ground& ground, MixedDrive joint_drive,
                  std::unique_ptr<TorqueSource> torques)
        : Mechanics(request, ground, 2, 1 + joint_drive.free_joints()),
          drive(std::move(joint_drive)),
          source(std::move(torques)) {}

    void write_state(const Chain& c, double* y) const override {
        const double position[3] = {c.x[0], c.y[0], c.theta[0]};
        const double rate[3] = {c.vx[0], c.vy[0], c.omega[0]};
        std::copy_n(position, 3, y);
        std::copy_n(rate, 3, y + coordinates);
        drive.free_angles(c.theta, y + 3);
        drive.free_angles(c.omega, y + coordinates + 3);
    }
    void fill_chain(double t, const double* y) override {
        const double* rate = y + coordinates;
        drive.place(t, y[2], rate[2], y + 3, rate + 3, chain);
        chain.x[0] = y[0];
        chain.y[0] = y[1];
        chain.vx[0] = rate[0];
        chain.vy[0] = rate[1];
        chain.follow(robot.l);
    }
    void load(double t, const double* y) override {
        fill_chain(t, y);
        chain.apply_ground(ground, robot.m * slope.gx, robot.m * slope.gy);
        source->torques(t, chain, driven.data());
        drive.limp(driven.data());
    }
    void accelerate() override {
        joints.T = driven;
        explicit_mixed(robot, drive.imposed(), drive.rotor(), drive.joint_accel(), chain, joints);
    }
    void derivative(const double* y, double* dy) const override {
        std::copy_n(y + coordinates, coordinates, dy);
        double* accel = dy + coordinates;
        accel[0] = chain.ax[0];
        accel[1] = chain.ay[0];
        accel[2] = chain.alpha[0];
        drive.free_angles(chain.alpha, accel + 3);
    }
    double next_jump(double t) const override { return source->next_jump(t); }
    void handle_jump(double t, const double* y) override {
        fill_chain(t, y);
        source->handle_jump(t, chain);
    }

  private:
    MixedDrive drive;
    std::unique_ptr<TorqueSource> source;
};

}  // namespace

std::unique_ptr<Mechanics> make_explicit(const RunRequest& request, const Ground& ground,
                                         double gear_friction) {
    if (!mixed(request)) return std::make_unique<ExplicitAngle>(request, ground);
    return std::make_unique<ExplicitMixed>(request, ground, mixed_drive(request),
                                           make_torques(request, gear_friction));
}

}  // namespace serpenoid
