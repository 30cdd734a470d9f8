// Exposes the vector kernels to Python: batches of gaits, and each instruction set to the tests.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "kernels/gait_batch.hpp"

namespace nb = nanobind;
using namespace serpenoid;

namespace {

using Vector = nb::ndarray<const double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Rows = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

std::vector<std::string> set_names() {
    std::vector<std::string> names;
    for (const kernels::Set* set : instruction_sets()) names.emplace_back(set->name);
    return names;
}

const kernels::Set& set_called(const std::string& name) {
    for (const kernels::Set* set : instruction_sets())
        if (name == set->name) return *set;
    throw nb::value_error("no such kernels on this processor");
}

auto to_numpy(const std::vector<double>& values, std::size_t rows) {
    auto memory = std::make_unique<double[]>(values.size());
    std::copy(values.begin(), values.end(), memory.get());
    double* data = memory.release();
    nb::capsule free(data, [](void* p) noexcept { delete[] static_cast<double*>(p); });
    return nb::ndarray<nb::numpy, double>(data, {rows, values.size() / rows}, free);
}

// gaits (G, 4): alpha, beta, omega, offset; starts (G, 4 n + 2). Ends, and the times reached.
nb::tuple run(const BatchScene& scene, Rows gaits, Rows starts, double dt, double duration,
              long steps, const std::string& set_name, bool batch) {
    const kernels::Set& set = set_called(set_name);
    const std::size_t count = gaits.shape(0);
    std::vector<Gait> list(count);
    for (std::size_t g = 0; g < count; ++g)
        list[g] = {gaits(g, 0), gaits(g, 1), gaits(g, 2), gaits(g, 3)};
    const std::vector<double> from(starts.data(), starts.data() + starts.size());
    GaitEnds ends;
    {
        nb::gil_scoped_release release;
        ends = run_gaits(scene, list, from, dt, duration, steps, set, batch);
    }
    return nb::make_tuple(to_numpy(ends.state, count), to_numpy(ends.reached, count));
}

// Rows: sine, cosine; as many values as a multiple of the packs' width.
auto kernel_sincos(const std::string& set_name, Vector x) {
    const kernels::Set& set = set_called(set_name);
    const std::size_t count = x.shape(0);
    if (count % set.width) throw nb::value_error("the packs must be full");
    const auto aligned = [&] { return new (std::align_val_t{64}) double[count]; };
    struct Delete {
        void operator()(double* p) const { ::operator delete[](p, std::align_val_t{64}); }
    };
    const std::unique_ptr<double[], Delete> in(aligned()), sine(aligned()), cosine(aligned());
    std::copy_n(x.data(), count, in.get());
    set.sincos(in.get(), sine.get(), cosine.get(), static_cast<long>(count) / set.width);
    std::vector<double> both(sine.get(), sine.get() + count);
    both.insert(both.end(), cosine.get(), cosine.get() + count);
    return to_numpy(both, 2);
}

}  // namespace

void bind_kernels(nb::module_& m) {
    nb::class_<BatchScene>(m, "BatchScene")
        .def("__init__", [](BatchScene* self, int n, double mass, double half_length,
                            double inertia, double ct, double cn, double ft0, double fn0,
                            double ct_back, double ft0_back, double k, double c, double smoothing) {
            new (self) BatchScene{{n, mass, half_length, inertia},
                                  {ct, cn, ft0, fn0, ct_back, ft0_back},
                                  {k, c},
                                  smoothing};
        });
    m.def("instruction_sets", &set_names);
    m.def("run_batch", &run);
    m.def("kernel_sincos", &kernel_sincos);
}
