// Where within a smooth piece (sliding_piece.hpp) the mode of a wheel ends: a sliding speed reaches
// zero, or the force on a wheel that sticks reaches its bound.
//
// The margin of a wheel is its speed, or its force's distance from the bound, in units of the aim;
// an event is aimed at a margin of -1, a little beyond the end of the mode. The force may pass from
// one bound to the other within a piece: its margin is that of the bound on the side of the end.
#pragma once

#include <vector>

#include "periodic/pieces/sliding_piece.hpp"

namespace serpenoid {

struct ModeEvent {
    double fraction = 1;  // of the piece
    int wheel = -1;       // none: the mode lasts
    bool sliding = false;
    double slope = 0;  // of the wheel's speed there, m/s a rad, where it slides
};

class EventFinder {
  public:
    EventFinder(const Robot& robot, SlidingPiece& piece)
        : wheels_(2 * robot.n), piece_(piece), margin_(wheels_), lowest_(wheels_) {}

    // Units of the margins: a speed, m/s, and a force over its bound.
    void set_units(double speed_eps, double force_eps) {
        speed_eps_ = speed_eps;
        force_eps_ = force_eps;
    }

    // The first event of the piece, which was solved with this mode over h of phase.
    ModeEvent first_event(const SlidingMode& mode, double h);

    // Of the last piece: a wheel's margins at the start and the stages, and a lower bound of them.
    const double* margins(int wheel) const { return margin_[wheel].value; }
    double lowest(int wheel) const { return lowest_[wheel]; }

  private:
    void set_margins(const SlidingMode& mode);
    double end_of_wheel(const double* margins, double limit) const;
    double end_of_rest(int wheel, double limit) const;
    double sharpen(int wheel, double sign, double x);

    int wheels_;
    SlidingPiece& piece_;
    std::vector<Lanes> margin_;
    std::vector<double> lowest_;
    double speed_eps_ = 0, force_eps_ = 0;
};

}  // namespace serpenoid
