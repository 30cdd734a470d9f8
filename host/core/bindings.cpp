// The only file that knows Python: exposes the simulation core as serpenoid._core.
#include <nanobind/nanobind.h>

namespace nb = nanobind;

void bind_firmware(nb::module_& parent);

NB_MODULE(_core, m) {
    m.doc() = "Compiled core of serpenoid; use the package's own functions instead.";
    bind_firmware(m);
}
