// Table of the time integration methods and of the scenes that each can run.
//
// Python reads it (simulation/scene.py) and refuses a scene that its method cannot run;
// run/simulation.cpp constructs the methods.
#pragma once

#include <stdexcept>
#include <string_view>

namespace serpenoid {

// Formulations and friction laws are lists of names (host/serpenoid/model/checks.py), separated by
// blanks.
struct MethodKind {
    const char* name;
    const char* formulations = "explicit implicit";
    const char* adaptive = "";  // formulations with step control; others use dt_s
    const char* laws = "viscous dry";
    bool faults = true;              // whether it runs limp and locked joints
    bool lags_damping = false;       // whether dampers use the rates of the previous step
    bool computes_friction = false;  // whether it computes set-valued friction

    constexpr bool is(std::string_view text) const { return text == name; }
};

inline constexpr MethodKind kMethods[] = {
    {.name = "rk4"},
    {.name = "paper", .formulations = "implicit", .lags_damping = true},
    {.name = "dop853", .adaptive = "explicit implicit", .laws = "viscous"},
    {.name = "radau",
     .formulations = "implicit",
     .adaptive = "implicit",
     .laws = "viscous",
     .faults = false},
    {.name = "nonsmooth", .adaptive = "explicit", .laws = "viscous dry", .computes_friction = true},
};

inline const MethodKind& method_kind(std::string_view name) {
    for (const MethodKind& kind : kMethods)
        if (kind.is(name)) return kind;
    throw std::invalid_argument("no such method");
}

}  // namespace serpenoid
