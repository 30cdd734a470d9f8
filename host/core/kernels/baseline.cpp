// The kernels for any processor: two doubles a pack (SSE2, NEON), and one, which tests hold them
// to.
#include "kernels/rk4_kernel.hpp"

namespace serpenoid::kernels {
const Set baseline = set_of<2>("baseline");
const Set scalar = set_of<1>("scalar");
}  // namespace serpenoid::kernels
