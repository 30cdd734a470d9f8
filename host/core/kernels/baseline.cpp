// The kernels for any processor: two doubles a pack (SSE2, NEON), and one, which tests hold them
// to.
#include "kernels/cycle_powers.hpp"
#include "kernels/rk4_kernel.hpp"
#include "kernels/stage_shape.hpp"

namespace serpenoid::kernels {
const Set baseline = set_of<2>("baseline", cycle_kernel<2>(), StageShape<2>::kernel());
const Set scalar = set_of<1>("scalar", cycle_kernel<1>(), StageShape<1>::kernel());
}  // namespace serpenoid::kernels
