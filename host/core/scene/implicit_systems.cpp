// The implicit model as first-order systems, one for each way to drive the joints.
#include <algorithm>
#include <memory>

#include "drive/joint_angles.hpp"
#include "model/implicit_model.hpp"
#include "scene/make_system.hpp"
#include "scene/terms.hpp"

namespace serpenoid {

namespace {

// What both share: state of the centres x, y, vx, vy of every link (n values each), and the
// order of the steps. What turns follows behind, in pairs of blocks.
class ImplicitSystem : public System {
  public:
    ImplicitSystem(const RunRequest& q, int turning_coordinates)
        : System(q.robot.n),
          robot(q.robot),
          spring(q.spring),
          force(ground_force(q)),
          damper(q.robot.n, q.method.holds_dampers),
          turns(turning_coordinates) {}

    int dim() const override { return 4 * robot.n + 2 * turns; }
    std::vector<int> rate_of() const override {
        std::vector<int> of(dim(), -1);
        for (int i = 0; i < 2 * robot.n; ++i) of[i] = 2 * robot.n + i;
        for (int i = 0; i < turns; ++i) of[4 * robot.n + i] = 4 * robot.n + turns + i;
        return of;
    }
    void latch() override { damper.latch(chain, robot.l); }

  protected:
    const double* angles(const double* y) const { return y + 4 * robot.n; }
    double* angles(double* y) const { return y + 4 * robot.n; }

    void set_centres(const Chain& c, double* y) const {
        const int n = robot.n;
        std::copy_n(c.x.data(), n, y), std::copy_n(c.y.data(), n, y + n);
        std::copy_n(c.vx.data(), n, y + 2 * n), std::copy_n(c.vy.data(), n, y + 3 * n);
    }
    void fill_centres(const double* y) {
        const int n = robot.n;
        std::copy_n(y, n, chain.x.data()), std::copy_n(y + n, n, chain.y.data());
        std::copy_n(y + 2 * n, n, chain.vx.data()), std::copy_n(y + 3 * n, n, chain.vy.data());
    }
    void act() {
        force(chain);
        spring_forces(robot, spring, damper, chain, joints);
    }
    void give_centres(const double* y, double* dy) const {
        const int n = robot.n;
        std::copy_n(y + 2 * n, 2 * n, dy);
        std::copy_n(chain.ax.data(), n, dy + 2 * n), std::copy_n(chain.ay.data(), n, dy + 3 * n);
    }

    Robot robot;
    JointSpring spring;
    GroundForce force;
    Damper damper;
    int turns;
};

// All angles imposed. State: the centres, then theta and omega of link 1.
class ImplicitAngle final : public ImplicitSystem {
  public:
    explicit ImplicitAngle(const RunRequest& q) : ImplicitSystem(q, 1), drive(q.robot.n, q.gait) {}

    void set(const Chain& c, double* y) const override {
        set_centres(c, y);
        angles(y)[0] = c.theta[0], angles(y)[1] = c.omega[0];
    }
    void fill(double t, const double* y) override {
        fill_centres(y);
        drive.place(t, angles(y)[0], angles(y)[1], chain);
    }
    void rate(double t, const double* y, double* dy) override {
        fill(t, y);
        act();
        const double turn = implicit_turn(robot, drive.joint_accel(), chain, joints);
        give_centres(y, dy);
        angles(dy)[0] = angles(y)[1], angles(dy)[1] = turn;
    }
    void forces(double t, const double* y) override {
        fill(t, y);
        act();
        implicit_angle(robot, drive.joint_accel(), chain, joints);
    }

  private:
    GaitDrive drive;
};

// Some angles imposed, some torques given. State: the centres, theta of link 1 and the free
// joints' angles, then the rates of these.
class ImplicitMixed final : public ImplicitSystem {
  public:
    ImplicitMixed(const RunRequest& q, MixedDrive joint_drive,
                  std::unique_ptr<TorqueSource> torques)
        : ImplicitSystem(q, 1 + joint_drive.free_joints()),
          drive(std::move(joint_drive)),
          source(std::move(torques)),
          scratch(q.robot.n) {}

    void set(const Chain& c, double* y) const override {
        set_centres(c, y);
        double *angle = angles(y), *rate = angle + turns;
        angle[0] = c.theta[0], rate[0] = c.omega[0];
        for (int f = 0; f < drive.free_joints(); ++f) {
            const int i = drive.free()[f];
            angle[1 + f] = c.theta[i + 1] - c.theta[i];
            rate[1 + f] = c.omega[i + 1] - c.omega[i];
        }
    }
    void fill(double t, const double* y) override {
        fill_centres(y);
        const double *angle = angles(y), *rate = angle + turns;
        drive.place(t, angle[0], rate[0], angle + 1, rate + 1, chain);
    }
    void forces(double t, const double* y) override {
        fill(t, y);
        act();
        double* T = joints.T.data();
        source->torques(t, chain, T);
        drive.limp(T);
        implicit_mixed(robot, drive.imposed(), drive.rotor(), drive.joint_accel(), scratch, chain,
                       joints);
    }
    void rate(double t, const double* y, double* dy) override {
        forces(t, y);
        const Chain& k = chain;
        give_centres(y, dy);
        double* turn = angles(dy);
        std::copy_n(angles(y) + turns, turns, turn);
        turn[turns] = k.alpha[0];
        for (int f = 0; f < drive.free_joints(); ++f) {
            const int i = drive.free()[f];
            turn[turns + 1 + f] = k.alpha[i + 1] - k.alpha[i];
        }
    }
    bool rate_fills_forces() const override { return true; }
    double next_jump(double t) const override { return source->next_jump(t); }
    void enter(double t, const double* y) override { fill(t, y), source->enter(t, chain); }

  private:
    MixedDrive drive;
    std::unique_ptr<TorqueSource> source;
    std::vector<double> scratch;
};

}  // namespace

std::unique_ptr<System> make_implicit(const RunRequest& q) {
    if (mixed(q)) return std::make_unique<ImplicitMixed>(q, mixed_drive(q), make_torques(q));
    return std::make_unique<ImplicitAngle>(q);
}

}  // namespace serpenoid
