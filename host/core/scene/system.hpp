// What a scene moves, as a system of first order y' = rate(t, y); methods see no more than this.
//
// The concrete systems are in explicit_systems.cpp and implicit_systems.cpp. A method pays one
// virtual call per right-hand side.
#pragma once

#include <limits>
#include <memory>
#include <vector>

#include "model/chain.hpp"

namespace serpenoid {

// The modes of a system whose motion is smooth while they last: wheels that rest or slide.
class Modes {
  public:
    virtual ~Modes() = default;
    // Find the modes that follow on a state; what rests in them is put to rest in it.
    virtual void find(double t, double* y) = 0;
    // How far each part is from the end of its mode: negative beyond, -1 the aim when it ends.
    virtual void margins(double t, const double* y, std::vector<double>& margin) = 0;
    // Whether what rests has crept by the errors of the steps, and is to be found anew.
    virtual bool creeps(double t, const double* y) = 0;
};

class System {
  public:
    explicit System(int links)
        : own_(std::make_unique<Parts>(links)), chain(own_->chain), joints(own_->joints) {}
    explicit System(System& around) : chain(around.chain), joints(around.joints) {}
    virtual ~System() = default;

    virtual int dim() const = 0;

    // The state of a chain, and the chain (places, angles, velocities) of a state.
    virtual void set(const Chain& from, double* y) const = 0;
    virtual void fill(double t, const double* y) = 0;

    // dy/dt, and no more than that takes.
    virtual void rate(double t, const double* y, double* dy) = 0;

    // The chain with its accelerations and the forces of the ground, and the joints, for a record.
    virtual void forces(double t, const double* y) = 0;

    // Whether rate() has done what forces() does: driven by torques, the motion needs all of it.
    virtual bool rate_fills_forces() const { return false; }

    // For every entry that is a place or an angle, the entry that is its rate; -1 for the others.
    virtual std::vector<int> rate_of() const = 0;

    // Some drives jump (setpoints, tables). The next jump after t, and what to do when it is
    // reached: the motion between two jumps is smooth.
    virtual double next_jump(double) const { return std::numeric_limits<double>::infinity(); }
    virtual void enter(double, const double*) {}

    // Those that its motion has, for a method that follows them.
    virtual Modes* modes() { return nullptr; }

    // The paper's scheme: keep the rates of the gaps as they are, for the dampers of the next step.
    virtual void latch() {}

  private:
    struct Parts {
        explicit Parts(int links) : chain(links), joints(links) {}
        Chain chain;
        Joints joints;
    };
    std::unique_ptr<Parts> own_;

  public:
    Chain& chain;
    Joints& joints;
};

}  // namespace serpenoid
