// The implicit model, one class for each way to drive the joints.
#include <algorithm>
#include <numeric>
#include <vector>

#include "scene/mechanics.hpp"

namespace serpenoid {

namespace {

double mean(const std::vector<double>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0) / values.size();
}

// Coordinates: x, y of the centre of mass, the gaps of all joints (x of each, then y of each), then
// angles. Stiff springs have tiny gaps: as states of their own they keep all their digits. Of the
// centre every method keeps the momentum to rounding, as joint forces come in pairs.
class ImplicitMechanics : public Mechanics {
  public:
    ImplicitMechanics(const RunRequest& q, const Ground& ground, int angles)
        : Mechanics(q, ground, 2 * q.robot.n, angles),
          spring(q.spring),
          damper(q.robot.n, q.method.holds_dampers) {
        gaps.resize(q.robot.n - 1);
    }

    void latch() override { damper.latch(gaps); }

  protected:
    void set_lengths(const Chain& from, double* y) const {
        Chain c = from;
        c.directions();
        const int n = robot.n;
        double* rate = y + coordinates;
        y[0] = mean(c.x);
        y[1] = mean(c.y);
        rate[0] = mean(c.vx);
        rate[1] = mean(c.vy);
        for (int i = 0; i + 1 < n; ++i) {
            const Gap g = gap(c, robot.l, i);
            y[2 + i] = g.x;
            y[n + 1 + i] = g.y;
            rate[2 + i] = g.vx;
            rate[n + 1 + i] = g.vy;
        }
    }
    // For a chain that has its angles, rates and directions.
    void fill_lengths(const double* y) {
        const int n = robot.n;
        const double* rate = y + coordinates;
        chain.x[0] = y[0];
        chain.y[0] = y[1];
        chain.vx[0] = rate[0];
        chain.vy[0] = rate[1];
        for (int i = 0; i + 1 < n; ++i)
            gaps[i] = {y[2 + i], y[n + 1 + i], rate[2 + i], rate[n + 1 + i]};
        chain.follow(robot.l, gaps.data());
        centre(chain.x, y[0]);
        centre(chain.y, y[1]);
        centre(chain.vx, rate[0]);
        centre(chain.vy, rate[1]);
    }
    void act() {
        force(chain);
        spring_forces(spring, damper, gaps, joints);
    }
    // theta'' of the links stand in chain.alpha.
    void differentiate_lengths(const double* y, double* dy) const {
        const Chain& k = chain;
        const int n = robot.n;
        std::copy_n(y + coordinates, coordinates, dy);
        double* accel = dy + coordinates;
        accel[0] = mean(k.ax);
        accel[1] = mean(k.ay);
        const auto tangential = [&](int i) { return k.omega[i] * k.omega[i]; };
        for (int i = 0; i + 1 < n; ++i) {
            const int j = i + 1;
            accel[2 + i] = k.ax[j] - k.ax[i] +
                           robot.l * (k.alpha[j] * k.s[j] + tangential(j) * k.c[j] +
                                      k.alpha[i] * k.s[i] + tangential(i) * k.c[i]);
            accel[n + 1 + i] = k.ay[j] - k.ay[i] -
                               robot.l * (k.alpha[j] * k.c[j] - tangential(j) * k.s[j] +
                                          k.alpha[i] * k.c[i] - tangential(i) * k.s[i]);
        }
    }

    JointSpring spring;
    Damper damper;

  private:
    static void centre(std::vector<double>& values, double place) {
        const double shift = place - mean(values);
        for (double& value : values) value += shift;
    }
};

// All angles imposed. Its angle: theta of link 1.
class ImplicitAngle final : public ImplicitMechanics {
  public:
    ImplicitAngle(const RunRequest& q, const Ground& ground)
        : ImplicitMechanics(q, ground, 1), drive(q.robot.n, q.gait) {}

    void set(const Chain& c, double* y) const override {
        set_lengths(c, y);
        y[lengths] = c.theta[0];
        y[coordinates + lengths] = c.omega[0];
    }
    void fill(double t, const double* y) override {
        drive.place(t, y[lengths], y[coordinates + lengths], chain);
        fill_lengths(y);
    }
    void load(double t, const double* y) override {
        fill(t, y);
        act();
    }
    void accelerate() override { implicit_angle(robot, drive.joint_accel(), chain, joints); }
    void derivative(const double* y, double* dy) const override {
        differentiate_lengths(y, dy);
        dy[coordinates + lengths] = chain.alpha[0];
    }

  private:
    GaitDrive drive;
};

// Some angles imposed, some torques given. Its angles: theta of link 1, the free joints' angles.
class ImplicitMixed final : public ImplicitMechanics {
  public:
    ImplicitMixed(const RunRequest& q, const Ground& ground, MixedDrive joint_drive,
                  std::unique_ptr<TorqueSource> torques)
        : ImplicitMechanics(q, ground, 1 + joint_drive.free_joints()),
          drive(std::move(joint_drive)),
          source(std::move(torques)),
          scratch(q.robot.n) {}

    void set(const Chain& c, double* y) const override {
        set_lengths(c, y);
        double* angle = y + lengths;
        double* rate = angle + coordinates;
        angle[0] = c.theta[0];
        rate[0] = c.omega[0];
        drive.free_angles(c.theta, angle + 1);
        drive.free_angles(c.omega, rate + 1);
    }
    void fill(double t, const double* y) override {
        const double* angle = y + lengths;
        const double* rate = angle + coordinates;
        drive.place(t, angle[0], rate[0], angle + 1, rate + 1, chain);
        fill_lengths(y);
    }
    void load(double t, const double* y) override {
        fill(t, y);
        act();
        source->torques(t, chain, driven.data());
        drive.limp(driven.data());
    }
    void accelerate() override {
        joints.T = driven;
        implicit_mixed(robot, drive.imposed(), drive.rotor(), drive.joint_accel(), scratch, chain,
                       joints);
    }
    void derivative(const double* y, double* dy) const override {
        differentiate_lengths(y, dy);
        double* accel = dy + coordinates + lengths;
        accel[0] = chain.alpha[0];
        drive.free_angles(chain.alpha, accel + 1);
    }
    double next_jump(double t) const override { return source->next_jump(t); }
    void enter(double t, const double* y) override {
        fill(t, y);
        source->enter(t, chain);
    }

  private:
    MixedDrive drive;
    std::unique_ptr<TorqueSource> source;
    std::vector<double> scratch;
};

}  // namespace

std::unique_ptr<Mechanics> make_implicit(const RunRequest& q, const Ground& ground,
                                         double gear_friction) {
    if (!mixed(q)) return std::make_unique<ImplicitAngle>(q, ground);
    return std::make_unique<ImplicitMixed>(q, ground, mixed_drive(q),
                                           make_torques(q, gear_friction));
}

}  // namespace serpenoid
