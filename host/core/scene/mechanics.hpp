// A chain with one way to drive its joints, without set-valued friction: state and accelerations.
//
// The state: coordinates (lengths in metres first, then angles), and their rates in the same order.
#pragma once

#include <limits>
#include <memory>
#include <vector>

#include "drive/joint_angles.hpp"
#include "model/chain.hpp"
#include "model/implicit_model.hpp"
#include "scene/run_request.hpp"
#include "scene/step_equations.hpp"

namespace serpenoid {

class Mechanics {
  public:
    Mechanics(const RunRequest& request, const Ground& ground, int lengths, int angles)
        : robot(request.robot),
          chain(robot.n),
          joints(robot.n),
          driven(robot.n - 1),
          lengths(lengths),
          coordinates(lengths + angles),
          ground(ground),
          slope(request.slope) {}
    virtual ~Mechanics() = default;

    // The state of a chain, and the chain (places, angles, velocities, directions) of a state.
    virtual void set(const Chain& source, double* y) const = 0;
    virtual void fill(double t, const double* y) = 0;

    // The forces of a state in three parts. load: fill the chain, the ground's forces and the
    // driving torques. accelerate: accelerations from the forces in the chain. recover: the joint
    // forces, where these accelerations did not take them.
    virtual void load(double t, const double* y) = 0;
    virtual void accelerate() = 0;
    virtual void recover() {}
    // dy/dt by the accelerations that stand in the chain.
    virtual void derivative(const double* y, double* dy) const = 0;

    // dy/dt, and no more than that takes; whether it has done what forces() does.
    virtual void rate(double t, const double* y, double* dy) {
        forces(t, y);
        derivative(y, dy);
    }
    virtual bool rate_fills_forces() const { return true; }
    void forces(double t, const double* y) {
        load(t, y);
        accelerate();
        recover();
    }

    // The next jump of the drive after t, and what to do when it is reached.
    virtual double next_jump(double) const { return std::numeric_limits<double>::infinity(); }
    virtual void enter(double, const double*) {}
    // The paper's scheme: keep the rates of the gaps as they are, for the dampers of the next step.
    virtual void latch() {}
    // The equations of an implicit step where these mechanics know better than a dense matrix.
    virtual std::unique_ptr<StepEquations> step_equations() { return nullptr; }

    Robot robot;
    Chain chain;
    Joints joints;
    std::vector<double> driven;  // torques of the free joints, by load()
    std::vector<Gap> gaps;       // of the joints; none where these are pins
    const int lengths, coordinates;

    const Ground ground;
    const Slope slope;
};

// With this ground instead of the request's, and servos whose gears have this friction, N m.
std::unique_ptr<Mechanics> make_explicit(const RunRequest& request, const Ground& ground,
                                         double gear_friction);
std::unique_ptr<Mechanics> make_implicit(const RunRequest& request, const Ground& ground,
                                         double gear_friction);
std::unique_ptr<TorqueSource> make_torques(const RunRequest& request, double gear_friction);

// Whether any joint is not imposed: driven by a torque, limp or locked.
inline bool mixed(const RunRequest& request) {
    return request.drive != Drive::angle || !request.faults.empty();
}

inline MixedDrive mixed_drive(const RunRequest& request) {
    return {request.robot.n, request.gait,       request.drive == Drive::angle,
            request.faults,  request.locked_rad, armature(request)};
}

}  // namespace serpenoid
