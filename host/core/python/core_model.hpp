// Robot, ground and gait as Python hands them over, and arrays as it gets them.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <initializer_list>
#include <memory>
#include <utility>
#include <vector>

#include "periodic/sweep.hpp"

using Model = serpenoid::SweepShape;

using Vector =
    nanobind::ndarray<const double, nanobind::ndim<1>, nanobind::c_contig, nanobind::device::cpu>;
using Table =
    nanobind::ndarray<const double, nanobind::ndim<2>, nanobind::c_contig, nanobind::device::cpu>;
using Array = nanobind::ndarray<nanobind::numpy, double>;

// Hand a vector's memory to NumPy.
inline Array to_numpy(std::vector<double>&& values, std::initializer_list<std::size_t> shape) {
    auto owner = std::make_unique<std::vector<double>>(std::move(values));
    double* data = owner->data();
    nanobind::capsule release(
        owner.release(), [](void* p) noexcept { delete static_cast<std::vector<double>*>(p); });
    return Array(data, shape, release);
}
