// The only file that knows Python: exposes the simulation core as serpenoid._core.
#include <nanobind/nanobind.h>

namespace nb = nanobind;

NB_MODULE(_core, m) {
    m.doc() = "Compiled core of serpenoid; use the package's own functions instead.";
}
