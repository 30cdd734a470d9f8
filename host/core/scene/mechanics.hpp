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

    // Write the state of a chain; fill the chain (positions, angles, velocities, directions) from a
    // state.
    virtual void write_state(const Chain& source, double* y) const = 0;
    virtual void fill_chain(double t, const double* y) = 0;

    // The forces of a state in three parts. load: the chain, the ground's forces and the driving
    // torques. accelerate: accelerations from these forces. find_joint_forces: the forces at the
    // joints, if accelerate has not found them.
    virtual void load(double t, const double* y) = 0;
    virtual void accelerate() = 0;
    virtual void find_joint_forces() {}
    // dy/dt from the accelerations that the chain holds.
    virtual void derivative(const double* y, double* dy) const = 0;

    // dy/dt alone, at the least cost; whether this also does all that forces() does.
    virtual void rate(double t, const double* y, double* dy) {
        forces(t, y);
        derivative(y, dy);
    }
    virtual bool rate_fills_forces() const { return true; }
    void forces(double t, const double* y) {
        load(t, y);
        accelerate();
        find_joint_forces();
    }

    // The time of the drive's next jump after t; handle_jump is called at that time.
    virtual double next_jump(double) const { return std::numeric_limits<double>::infinity(); }
    virtual void handle_jump(double, const double*) {}
    // For the paper's scheme: store the rates of the gaps for the dampers of the next step.
    virtual void latch() {}
    // The equations of an implicit step, if these mechanics have cheaper ones than a dense matrix.
    virtual std::unique_ptr<StepEquations> step_equations() { return nullptr; }

    Robot robot;
    Chain chain;
    Joints joints;
    std::vector<double> driven;  // torques of the free joints, by load()
    std::vector<Gap> gaps;       // gaps of the joints; none if the joints are pins
    const int lengths, coordinates;

    const Ground ground;
    const Slope slope;
};

// Mechanics of a request, but with this ground, and with servos of this gear friction, N m.
std::unique_ptr<Mechanics> make_explicit(const RunRequest& request, const Ground& ground,
                                         double gear_friction);
std::unique_ptr<Mechanics> make_implicit(const RunRequest& request, const Ground& ground,
                                         double gear_friction);
std::unique_ptr<TorqueSource> make_torques(const RunRequest& request, double gear_friction);

// Whether any joint is driven by a torque, limp or locked.
inline bool mixed(const RunRequest& request) {
    return request.drive != Drive::angle || !request.faults.empty();
}

inline MixedDrive mixed_drive(const RunRequest& request) {
    return {request.robot.n, request.gait,       request.drive == Drive::angle,
            request.faults,  request.locked_rad, armature(request)};
}

}  // namespace serpenoid
