// Radau IIA of order 5 with adaptive steps, for motion beside decays and ringing far faster than
// it.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "methods/method.hpp"
#include "numerics/dense.hpp"
#include "numerics/radau_collocation.hpp"
#include "scene/system.hpp"

namespace serpenoid {

// Three stages, solved by simplified Newton iteration in the coordinates in which the rule's matrix
// has one real and two complex eigenvalues mu (Hairer, Wanner, Solving Ordinary Differential
// Equations II, IV.8). The unknowns are the rates v of the stages; the coordinates follow exactly,
// q = q_0 + h A v. So the matrices have the size of the coordinates (step_equations.hpp).
//
// The error is the embedded one of order 3, filtered by the real matrix: in a stiff direction it is
// then the distance from the slow motion. It counts in places, and in rates by the places that they
// lead to within the step. So ringing and decays are followed where they swing by more than the
// tolerance, and stepped over where they do not, however fast they are. An error of motion that the
// steps resolve counts more, as it adds up over them; of what is stepped over, the swing bounds the
// whole.
//
// What is integrated beside the motion follows it and chooses nothing.
class Radau final : public Method {
  public:
    // Weights of errors beside those of places, which have 1.
    struct Weights {
        // Of motion that the steps resolve: it adds up over the steps that follow ringing. With 1
        // torque tables of 24 links at k = 1e9 were off by two tolerances, with 6 by one.
        double resolved = 6;
        // Of rates. The ends of modes are found by rates: with .01 the transient behind a servo's
        // setpoint was stepped over, and links below 1e-3 kg changed their modes in it for ever;
        // with .1 one of 180 random runs still did, with .3 none of 360.
        double rate = 0;
    };

    // `scale`: what counts as 1 in each entry of the state.
    Radau(System& system, const std::vector<double>& scale, double tolerance,
          const Weights& weights);

    void restart(double t, const double* y) override { begin(t, y, h_next_, shortest_); }
    // `first`: length of the first step, s. It fails before it would take one below `shortest`,
    // s, unless a limit cuts it.
    void begin(double t, const double* y, double first, double shortest);
    const char* step(double t_limit) override;
    double time() const override { return t_; }
    const double* state() const override { return y_.data(); }
    int dense_order() const override { return 3; }
    void dense(double t, double* y) const override;
    double local_error() const override { return error_ * tolerance_; }
    int unknowns() const { return m_; }

  private:
    static constexpr int kStages = 3;
    using Rule = RadauRule<kStages>;
    using Vector = std::vector<double>;
    using Stages = std::array<Vector, kStages>;

    bool linearise(double h);
    void predict(double h);
    void set_stages(double h);
    double iterate(double h);
    bool solve(double h);
    double error(double h);
    void accept(double h, double t);

    System& system_;
    int m_, dim_;  // coordinates; entries of a state
    double tolerance_;
    double unit_s_;  // of the motion's time
    Weights weights_;
    Vector weight_;  // 1 / (scale tolerance)
    double t_ = 0, t_old_ = 0;
    double h_ = 0;  // of the last step, 0 after a restart
    double h_next_ = 0, shortest_ = 0;
    double error_ = 0;  // of the last step, over the tolerance
    int iterations_ = 0;
    Vector y_, y_old_, scratch_, moved_;
    Stages change_;              // of the rates from the start of the step to its stages
    Stages stage_, stage_rate_;  // states, and dy/dt of these
    Stages past_;                // states of the last step's stages
    std::unique_ptr<StepEquations> equations_;
    Vector real_change_, filter_, place_;
    std::vector<StepEquations::Complex> complex_change_;
};

}  // namespace serpenoid
