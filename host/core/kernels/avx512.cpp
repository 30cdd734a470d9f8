// The kernels for x86 processors with AVX-512, packs as for AVX2 and the same bits: more registers,
// and single numbers read as operands. The build compiles this file alone for those.
#include "kernels/cycle_powers.hpp"
#include "kernels/rk4_kernel.hpp"
#include "kernels/stage_shape.hpp"

namespace serpenoid::kernels {
#ifdef __AVX512VL__
const Set avx512 = set_of<4>("avx512", cycle_kernel<4>(), StageShape<4>::kernel());
#else
const Set avx512 = {};  // another kind of processor
#endif
}  // namespace serpenoid::kernels
