// Exposes each set of vector kernels to the tests.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "kernels/packed_run.hpp"
#include "scene/run_request.hpp"

namespace nb = nanobind;
using namespace serpenoid;

namespace {

using Vector = nb::ndarray<const double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

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

// The end (4 n + 2,) of a run from such a start, with steps of dt and a shorter last one.
auto kernel_run(const std::string& set_name, const RunRequest& q, Vector start) {
    PackedRun run(q.robot, q.ground, q.spring, q.slope, q.smoothing, q.gait, set_called(set_name));
    std::vector<double> y(start.data(), start.data() + start.size());
    if (start.size() != static_cast<std::size_t>(run.dim())) throw nb::value_error("start");
    run.set(y.data());
    for (long i = 0; i < q.steps; ++i)
        run.step(static_cast<double>(i) * q.dt,
                 i + 1 < q.steps ? static_cast<double>(i + 1) * q.dt : q.duration);
    run.get(y.data());
    return to_numpy(y, 1);
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
    m.def("instruction_sets", &set_names);
    m.def("kernel_run", &kernel_run);
    m.def("kernel_sincos", &kernel_sincos);
}
