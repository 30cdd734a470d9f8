// Where within a smooth piece (sliding_piece.hpp) the mode of a wheel ends: a sliding speed reaches
// zero, or the force on a wheel that sticks reaches its bound.
//
// The margin of a wheel is its speed, or the distance of its force from the bound, in units of
// set_units. An event is searched for at a margin of -1, a little after the end of the mode. A
// force has two bounds, +bound and -bound; its margin is taken from the one of its sign at the end
// of the piece.
#pragma once

#include <vector>

#include "periodic/pieces/sliding_piece.hpp"

namespace serpenoid {

struct ModeEvent {
    double fraction = 1;   // of the piece
    int wheel = -1;        // -1: no event, the mode lasts
    bool sliding = false;  // whether the wheel slid until then
    double slope = 0;      // d speed / d phase of a sliding wheel at the event, m/s a rad
};

class EventFinder {
  public:
    EventFinder(const Robot& robot, SlidingPiece& piece)
        : wheels_(2 * robot.n), piece_(piece), margin_(wheels_), lower_bound_(wheels_) {}

    // Units of the margins: a speed in m/s, and a force as a fraction of its bound.
    void set_units(double speed_eps, double force_eps) {
        speed_eps_ = speed_eps;
        force_eps_ = force_eps;
    }

    // The first event of the piece, which was solved with this mode over h of phase.
    ModeEvent first_event(const SlidingMode& mode, double h);

    // A wheel's margins at the start and the stages of the last piece, and a lower bound of the
    // margin on the piece.
    const double* margins(int wheel) const { return margin_[wheel].value; }
    double lower_bound(int wheel) const { return lower_bound_[wheel]; }

  private:
    void set_margins(const SlidingMode& mode);
    double end_of_wheel(const double* margins, double limit) const;
    double end_of_rest(int wheel, double limit) const;
    double refine_stop(int wheel, double sign, double x);

    int wheels_;
    SlidingPiece& piece_;
    std::vector<Lanes> margin_;
    std::vector<double> lower_bound_;
    double speed_eps_ = 0, force_eps_ = 0;
};

}  // namespace serpenoid
