// The map of a cycle (or half of one) on dry ground, with its derivative: smooth pieces
// (sliding_piece.hpp) from one change of mode to the next.
//
// A mode ends where a sliding speed reaches zero or a stuck wheel's force its bound; the piece's
// polynomial tells where. One very short implicit step there, a convex problem
// (kinked_quadratic.hpp) that knows no mode, finds the next. At an end of sliding the rate of p
// jumps from f- to f+, and a trajectory that starts beside this one gets there a little earlier or
// later: the derivative is multiplied by 1 + (f+ - f-) grad(v) / v', v being the speed that reaches
// zero. Where a wheel breaks loose the rate is continuous, and nothing happens to the derivative.
#pragma once

#include <array>
#include <utility>
#include <vector>

#include "numerics/kinked_quadratic.hpp"
#include "periodic/sliding_piece.hpp"

namespace serpenoid {

struct CycleState {
    Vec3 p{};                        // nm Vx, nm Vy, L
    double theta = 0, x = 0, y = 0;  // heading, and place in axes that turn by `spin`
    double dissipated = 0;           // J
    std::array<Vec3, 7> by_start{};  // derivatives of p, theta, x, y, dissipated by the first p
};

class DryCycle {
  public:
    DryCycle(const Robot& robot, const Ground& ground, const Gait& gait);

    // Follow from p at phase 0 to tau_end. Local errors stay below `tolerance` of the scales.
    // spin: turning of the axes in which x, y are counted, rad a rad. Returns false when the pieces
    // run out or get too short: stiff or wild motion.
    bool follow(const Vec3& p, double tau_end, double tolerance, double spin, CycleState& to);

    // From here on `follow` adds up the time integrals of each P_i^+, J, too; null: no more.
    void watch_powers(std::vector<double>* positive) { positive_ = positive; }
    double net_work() const { return net_work_; }  // of the joints then, J
    // And what of the positive work hangs on wheels of which the motion does not tell whether they
    // come to rest, J.
    double doubtful_work() const { return doubtful_work_; }
    // Whether wheels that slid stopped or turned at one and the same moment: which is the first
    // beside this motion hangs on the way one is beside it, so there is no one derivative.
    bool together() const { return together_; }

    const Vec3& scale() const { return scale_; }  // of p
    double rate(double L, double tau);            // w for a given L
    double momentum(double w, double tau);
    long pieces() const { return pieces_; }
    void limit(long pieces) { most_ = pieces; }  // of all calls together

  private:
    struct Ending {
        double at = 1;  // fraction of the piece
        int wheel = -1;
        bool sliding = false;
    };
    struct Jump {  // of the derivative, waiting for the rate after the event
        bool waits = false;
        int wheel;
        double sign, slope;
        Vec3 rate, gradient;  // of the speed that reached zero
    };
    bool kick(CycleState& state, double& tau, double tau_end, double length);
    bool change_mode(CycleState& state, double& tau, double tau_end, const Ending& ending);
    bool kick_on(CycleState& state, double& tau, double tau_end, const Ending& ending);
    void note_changes();
    void set_mode();
    void settle_stuck(CycleState& state);
    void margins();
    double end_of_wheel(const double* margins, double first) const;
    double sharpen(int wheel, double x);
    Ending ending();
    void jump(const Vec3& rate_after, CycleState& state);
    void await_jump(const Ending& ending, double h);
    std::pair<double, Vec3> dissipation(const SlidingPiece::Node& node, const Vec3& u) const;
    void accumulate(double h, double x, CycleState& state);
    void add_positive(double tau, double h, double x);
    void add_kick_work();
    void add_doubt(double h, double x);
    void add_part(double tau, double h, double from, double wide);
    bool advance(CycleState& state, double tau_end, double tolerance);

    Robot robot_;
    Ground ground_;
    double alpha_, omega_, nm_, spin_ = 0, tau_start_ = 0;
    Vec3 scale_;
    GaitTable table_;
    std::vector<double> lag_;  // of every joint, rad
    BodyShape shape_;
    SlidingPiece piece_;
    std::vector<SlidingPiece::Lanes> margin_;
    std::vector<double> lowest_;  // of the margins, a bound
    std::vector<SlidingPiece::Lanes> torque_, rate_;
    std::vector<double> apart_;
    SlidingMode mode_;
    Convex3 convex_;
    std::vector<Kink> kinks_;
    std::vector<int> wheel_of_kink_;
    std::vector<double> way_;     // of every wheel before a kick, by its sign
    std::vector<double> before_;  // what every wheel did before a change of mode
    std::vector<char> fresh_;     // wheels that have just begun to slide their way
    Jump jump_;
    std::vector<double>* positive_ = nullptr;
    double net_work_ = 0, doubtful_work_ = 0;
    bool together_ = false;
    double step_ = 0.3, speed_eps_ = 0, force_eps_ = 0, shortest_kick_ = 0, longest_kick_ = 0,
           kick_ = 0, skipped_ = 0;
    long pieces_ = 0, most_ = 1'000'000;
};

}  // namespace serpenoid
