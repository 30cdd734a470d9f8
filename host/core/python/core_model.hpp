// Robot, ground and gait as Python hands them over.
#pragma once

#include "model/params.hpp"

struct Model {
    serpenoid::Robot robot;
    serpenoid::Ground ground;
    serpenoid::Gait gait;
};
