// The fast way for the exact model with imposed joint angles on flat viscous ground: collocation
// on pieces of the cycle whose maps are made once, however long the run.
#pragma once

#include <array>
#include <unordered_map>

#include "body/frame_change.hpp"
#include "body/viscous_piece.hpp"
#include "methods/method.hpp"

namespace serpenoid {

// Half a cycle later every joint angle has changed sign, and the motion goes on as the mirror
// image of one over the first half: one half of tables serves both (a gait that steers needs the
// whole). The span is halved again and again as accuracy asks for; piece number 2^level + i is
// the i-th of 2^level equal ones, its halves are twice that number and the next.
//
// The estimate of error is that of the dense output (radau_collocation.hpp); the ends of the
// pieces, by which the run goes on, are far better: order 11 where the interpolation has 7.
class Collocation final : public Method {
  public:
    Collocation(const Robot& robot, const Ground& ground, const Gait& gait, double tolerance);

    // y: x, y, theta of link 1, then their rates; ground frame.
    void restart(double t, const double* y) override;
    StepOutcome step(double t_limit) override;
    double time() const override { return t_; }
    const double* state() const override;
    int dense_order() const override { return 7; }
    void dense(double t, double* y) const override;
    double local_error() const override { return error_ * tolerance_; }

  private:
    using Piece = unsigned long long;
    static constexpr int kDeepest = 56;
    static constexpr long kMostPieces = 100000;     // of a span
    static constexpr std::size_t kMostKept = 4096;  // about 10 MB
    bool advance();
    double solve(PhaseElement& element);
    PhaseElement& element();
    void next_piece();
    int level() const;
    double phase(Piece i) const;
    BodyState at(double x) const;

    Robot robot_;
    Ground ground_;
    double omega_, tolerance_, span_, scale_[PhaseElement::count];
    bool mirrored_;
    int coarsest_;
    GaitTable table_;
    BodyShape scratch_;
    std::unordered_map<Piece, PhaseElement> kept_;

    double origin_s_ = 0, t_ = 0, from_s_ = 0, to_s_ = 0, error_ = 0;
    long spans_ = 0, pieces_ = 0;  // whole spans so far, and pieces in the present one
    double side_ = 1;              // -1 in mirrored spans
    Piece piece_ = 0;
    BodyState start_{}, end_{};
    double start_side_ = 1;
    PhaseElement::Solution now_;
    // the frame of the records costs as much as a step: made when asked for
    mutable bool fresh_ = false;
    mutable std::array<double, 6> y_{};
    mutable BodyShape shape_;
};

}  // namespace serpenoid
