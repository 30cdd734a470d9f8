// The implicit model as first-order systems, one for each way to drive the joints.
#pragma once

#include <memory>

#include "drive/joint_angles.hpp"
#include "model/ground_force.hpp"
#include "model/implicit_model.hpp"
#include "scene/run_request.hpp"
#include "scene/system.hpp"

namespace serpenoid {

// What the three share: state of the centres x, y, vx, vy of every link (n values each), and the
// order of the steps. What turns follows behind, in pairs of blocks.
template <class Force, class Damper>
class ImplicitSystem : public System {
  public:
    ImplicitSystem(const RunRequest& q, int turning_coordinates)
        : System(q.robot.n),
          robot(q.robot),
          spring(q.spring),
          force(q.ground, q.smoothing, q.slope, q.robot.m),
          damper(q.robot.n),
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
    Force force;
    Damper damper;
    int turns;
};

// All angles imposed. State: the centres, then theta and omega of link 1.
template <class Force, class Damper>
class ImplicitAngle final : public ImplicitSystem<Force, Damper> {
  public:
    explicit ImplicitAngle(const RunRequest& q)
        : ImplicitSystem<Force, Damper>(q, 1), drive(q.robot.n, q.gait) {}

    void set(const Chain& c, double* y) const override {
        this->set_centres(c, y);
        this->angles(y)[0] = c.theta[0], this->angles(y)[1] = c.omega[0];
    }
    void fill(double t, const double* y) override {
        this->fill_centres(y);
        drive.place(t, this->angles(y)[0], this->angles(y)[1], this->chain);
    }
    void rate(double t, const double* y, double* dy) override {
        fill(t, y);
        this->act();
        const double turn =
            implicit_turn(this->robot, drive.joint_accel(), this->chain, this->joints);
        this->give_centres(y, dy);
        this->angles(dy)[0] = this->angles(y)[1], this->angles(dy)[1] = turn;
    }
    void forces(double t, const double* y) override {
        fill(t, y);
        this->act();
        implicit_angle(this->robot, drive.joint_accel(), this->chain, this->joints);
    }

  private:
    GaitDrive drive;
};

// All torques given. State: the centres, then theta and omega of every link (n values each).
template <class Force, class Damper>
class ImplicitTorque final : public ImplicitSystem<Force, Damper> {
  public:
    ImplicitTorque(const RunRequest& q, std::unique_ptr<TorqueSource> torques)
        : ImplicitSystem<Force, Damper>(q, q.robot.n), source(std::move(torques)) {}

    void set(const Chain& c, double* y) const override {
        const int n = this->robot.n;
        this->set_centres(c, y);
        std::copy_n(c.theta.data(), n, this->angles(y));
        std::copy_n(c.omega.data(), n, this->angles(y) + n);
    }
    void fill(double, const double* y) override {
        const int n = this->robot.n;
        this->fill_centres(y);
        std::copy_n(this->angles(y), n, this->chain.theta.data());
        std::copy_n(this->angles(y) + n, n, this->chain.omega.data());
        this->chain.directions();
    }
    void forces(double t, const double* y) override {
        fill(t, y);
        this->act();
        source->torques(t, this->chain, this->joints.T.data());
        implicit_torque(this->robot, this->chain, this->joints);
    }
    void rate(double t, const double* y, double* dy) override {
        const int n = this->robot.n;
        forces(t, y);
        this->give_centres(y, dy);
        std::copy_n(this->angles(y) + n, n, this->angles(dy));
        std::copy_n(this->chain.alpha.data(), n, this->angles(dy) + n);
    }
    bool rate_fills_forces() const override { return true; }
    double next_jump(double t) const override { return source->next_jump(t); }
    void enter(double t, const double* y) override { fill(t, y), source->enter(t, this->chain); }

  private:
    std::unique_ptr<TorqueSource> source;
};

// Some angles imposed, some torques given. State: the centres, theta of link 1 and the free
// joints' angles, then the rates of these.
template <class Force, class Damper>
class ImplicitMixed final : public ImplicitSystem<Force, Damper> {
  public:
    ImplicitMixed(const RunRequest& q, MixedDrive joint_drive,
                  std::unique_ptr<TorqueSource> torques)
        : ImplicitSystem<Force, Damper>(q, 1 + joint_drive.free_joints()),
          drive(std::move(joint_drive)),
          source(std::move(torques)),
          scratch(q.robot.n) {}

    void set(const Chain& c, double* y) const override {
        this->set_centres(c, y);
        double *angle = this->angles(y), *rate = angle + this->turns;
        angle[0] = c.theta[0], rate[0] = c.omega[0];
        for (int f = 0; f < drive.free_joints(); ++f) {
            const int i = drive.free()[f];
            angle[1 + f] = c.theta[i + 1] - c.theta[i];
            rate[1 + f] = c.omega[i + 1] - c.omega[i];
        }
    }
    void fill(double t, const double* y) override {
        this->fill_centres(y);
        const double *angle = this->angles(y), *rate = angle + this->turns;
        drive.place(t, angle[0], rate[0], angle + 1, rate + 1, this->chain);
    }
    void forces(double t, const double* y) override {
        fill(t, y);
        this->act();
        double* T = this->joints.T.data();
        source->torques(t, this->chain, T);
        drive.limp(T);
        implicit_mixed(this->robot, drive.imposed(), drive.rotor(), drive.joint_accel(), scratch,
                       this->chain, this->joints);
    }
    void rate(double t, const double* y, double* dy) override {
        forces(t, y);
        const Chain& k = this->chain;
        this->give_centres(y, dy);
        double* turn = this->angles(dy);
        std::copy_n(this->angles(y) + this->turns, this->turns, turn);
        turn[this->turns] = k.alpha[0];
        for (int f = 0; f < drive.free_joints(); ++f) {
            const int i = drive.free()[f];
            turn[this->turns + 1 + f] = k.alpha[i + 1] - k.alpha[i];
        }
    }
    bool rate_fills_forces() const override { return true; }
    double next_jump(double t) const override { return source->next_jump(t); }
    void enter(double t, const double* y) override { fill(t, y), source->enter(t, this->chain); }

  private:
    MixedDrive drive;
    std::unique_ptr<TorqueSource> source;
    std::vector<double> scratch;
};

}  // namespace serpenoid
