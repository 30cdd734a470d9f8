// Every method of runs in time: which scenes it runs.
//
// The one registry. Python reads it (simulation/scene.py), and refuses with it what a method does
// not run; run/simulation.cpp has how each is made.
#pragma once

#include <stdexcept>
#include <string_view>

namespace serpenoid {

// Lists are words (host/serpenoid/model/checks.py) with a blank between them.
struct MethodKind {
    const char* name;
    const char* formulations = "explicit implicit";
    const char* adaptive = "";  // formulations in which it picks its steps; in the others dt_s
    const char* laws = "viscous dry";
    bool faults = true;           // runs with limp or locked joints
    bool holds_dampers = false;   // dampers take the rates of the step before
    bool makes_friction = false;  // implicit: applies the friction itself, to a system without

    constexpr bool is(std::string_view text) const { return text == name; }
};

inline constexpr MethodKind kMethods[] = {
    {.name = "rk4"},
    {.name = "paper", .formulations = "implicit", .holds_dampers = true},
    {.name = "dop853", .adaptive = "explicit implicit", .laws = "viscous"},
    {.name = "radau",
     .formulations = "implicit",
     .adaptive = "implicit",
     .laws = "viscous",
     .faults = false},
    {.name = "nonsmooth", .adaptive = "explicit", .laws = "viscous dry", .makes_friction = true},
};

inline const MethodKind& method_kind(std::string_view name) {
    for (const MethodKind& kind : kMethods)
        if (kind.is(name)) return kind;
    throw std::invalid_argument("no such method");
}

}  // namespace serpenoid
