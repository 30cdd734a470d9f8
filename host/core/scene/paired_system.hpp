// What explicit systems have in common: places first, then their rates in the same order.
#pragma once

#include <memory>
#include <vector>

#include "scene/run_request.hpp"
#include "scene/system.hpp"

namespace serpenoid {

class PairedSystem : public System {
  public:
    PairedSystem(int links, int coordinates)
        : System(links), driven(links - 1), half(coordinates) {}
    int dim() const override { return 2 * half; }

    // forces() in three parts. load: fill the chain, the ground's forces and the driving torques.
    // accelerate: accelerations from the forces in the chain. recover: the joint forces, where
    // these accelerations did not take them.
    virtual void load(double t, const double* y) = 0;
    virtual void accelerate() = 0;
    virtual void recover() {}
    std::vector<double> driven;  // driving torques of the free joints, by load()
    void forces(double t, const double* y) final { load(t, y), accelerate(), recover(); }
    // dy/dt by the accelerations that stand in the chain.
    virtual void derivative(const double* y, double* dy) const = 0;

    std::vector<int> rate_of() const override {
        std::vector<int> of(2 * half, -1);
        for (int i = 0; i < half; ++i) of[i] = half + i;
        return of;
    }

  protected:
    int half;
};

std::unique_ptr<PairedSystem> make_paired(const RunRequest& request);

}  // namespace serpenoid
