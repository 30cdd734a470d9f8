// Periodic state on dry ground: Newton's method on the map of dry_cycle.hpp, which brings its
// derivative with it.
//
// Unknown is the state at phase 0; its image is the mirror image half a cycle later (a whole cycle
// later, as it is, for a gait that steers). At a tolerance Newton's method runs until its next step
// is small enough for the derivatives to stand for it; then the tolerance is tightened until the
// speed stops changing: the last change is the error estimate. Where the pieces run out the
// implicit steps of dry_by_steps.hpp take over, and where they fail, too, plain following.
#pragma once

#include "periodic/dry_cycle.hpp"
#include "periodic/periodic_state.hpp"

namespace serpenoid {

// Solves for one shape and any number of rates; each starts from the one before.
class SteadyDry {
  public:
    SteadyDry(const Robot& robot, const Ground& ground, const Gait& gait)
        : robot_(robot), ground_(ground), gait_(gait) {}

    SteadyState solve(double omega, const SteadyOptions& options);

  private:
    struct Known {
        double omega;
        Vec3 z;
    };
    struct Changes {  // from one level to the next
        double speed = 0, power = 0, slowest = 0;
    };
    struct Level {
        double tolerance, moved;  // of the state, over the scales
    };
    static Changes changes(const SteadyState& fine, const SteadyState& coarse);
    void claim(const DryCycle& cycle, const SteadyOptions& options, const Level& level,
               const SteadyState& coarse, const Changes& before, SteadyState& out) const;
    enum class Ended { converged, stalled, broken };
    SteadyState at_rest(double omega, const SteadyOptions& options) const;
    SteadyState by_pieces(DryCycle& cycle, const SteadyOptions& options, double from);
    bool wander(DryCycle& cycle, int most, double near, double tolerance, double share = 1);
    Ended newton(DryCycle& cycle, double tolerance, double goal, bool powers, SteadyState& out);
    bool step(const Vec3& r, Vec3& d, double lag = 0) const;
    bool shorten(const Vec3& r, double reach, Vec3& d) const;
    void image(const CycleState& end, Vec3& r);
    void report(DryCycle& cycle, const Vec3& d, double tolerance, SteadyState& out);
    void add_positive(std::vector<double>& before, SteadyState& out) const;
    double follows(int row, const DryCycle& cycle) const;
    double excess(const SteadyState& s, const SteadyOptions& options) const;
    void guess(double omega);
    void remember(double omega, bool converged);
    double slackness() const;
    double span() const { return gait_.offset == 0 ? M_PI : 2 * M_PI; }

    Robot robot_;
    Ground ground_;
    Gait gait_;
    bool near_ = false;             // the state is good to a tolerance
    bool promising_ = false;        // guesses are so good that the first map may do
    std::vector<Known> known_;      // up to three rates, the last one last
    Vec3 z_{};                      // state at phase 0, over the scales
    CycleState end_;                // of the last map
    std::vector<double> positive_;  // and its integrals of P_i^+, J
    double net_work_ = 0;           // and the joints' work, J
    double doubtful_work_ = 0;      // and what is not sure of theirs
    bool together_ = false;         // whether wheels stopped at one moment
    Mat3 M_{};                      // derivative of the image by the state, over the scales
};

}  // namespace serpenoid
