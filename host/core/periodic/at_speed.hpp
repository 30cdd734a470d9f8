// The rates at which shapes of gait have wanted speeds on viscous ground, and the powers there.
//
// The states of a pack of four rates cost hardly more than that of one. Cubics through them give
// ln rate and ln power over ln speed. Where quadratics through the three nearest agree, that is the
// answer. Else a narrower pack follows round the rate found, or one farther on.
#pragma once

#include <array>

#include "periodic/rates_of_shape.hpp"

namespace serpenoid {

struct SpeedWish {
    double speed = 0;    // m/s
    double spread = 0;   // e-folds of rate: how well the gait's own rate is expected to give it
    double highest = 0;  // rate, rad/s
};

struct AtSpeed {
    double omega = 0, power = 0, abs_power = 0, positive_power = 0;
    double error = 0;               // of speed, relative
    std::array<double, 4> slope{};  // of ln rate and of each ln power, against ln speed
    bool found = false;
};

// Where to look for the lowest cost of a valley of shapes: swing (ln of the headings' amplitude,
// alpha / (2 sin(beta / 2))) and lag (ln beta).
struct ValleyStart {
    double swing = 0, lag = 0, log_rate = 0;  // ln rate: about
    double radius = 0, smallest = 0;          // half of the first and of the last box
    std::array<double, 2> low{}, high{};      // bounds of swing and lag
};

struct ValleyEnd {
    double swing = 0, lag = 0;
    AtSpeed state;
    double gap = 0;                   // e-folds: how far the last model is from this cost
    std::array<double, 3> tangent{};  // of swing, lag and ln rate of the optimum, to ln speed
    int shapes = 0;                   // solved
    bool inside = false;  // else no answer: a shape has no state, or the lowest is at a bound
};

// The rate near the gait's own that gives the speed.
AtSpeed at_speed(const Robot& robot, const Ground& ground, const Gait& gait, const SpeedWish& wish,
                 const SteadyOptions& options);

// The shape of lowest cost (0: net, 1: absolute, 2: positive power) at a speed.
ValleyEnd lowest_shape(const Robot& robot, const Ground& ground, const ValleyStart& start, int cost,
                       const SpeedWish& wish, const SteadyOptions& options);

}  // namespace serpenoid
