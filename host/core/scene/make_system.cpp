// Formulation first, then the terms (explicit_systems.cpp, implicit_systems.cpp).
#include "scene/make_system.hpp"

namespace serpenoid {

std::unique_ptr<System> make_system(const RunRequest& q) {
    if (q.formulation == Formulation::explicit_) return make_explicit(q);
    if (!q.method.makes_friction) return make_implicit(q);
    RunRequest bare = q;  // the method itself applies the friction
    bare.ground = {0, 0, 0, 0};
    return make_implicit(bare);
}

}  // namespace serpenoid
