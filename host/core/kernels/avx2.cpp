// The kernels for x86 processors with AVX2 and FMA; the build compiles this file alone for those.
#include "kernels/cycle_powers.hpp"
#include "kernels/rk4_kernel.hpp"
#include "kernels/stage_shape.hpp"

namespace serpenoid::kernels {
#ifdef __AVX2__
const Set avx2 = set_of<4>("avx2", cycle_kernel<4>(), StageShape<4>::kernel());
#else
const Set avx2 = {};  // another kind of processor
#endif
}  // namespace serpenoid::kernels
