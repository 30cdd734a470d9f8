// The lab's chain for Python, as serpenoid._core.LabChain.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "lab/lab_chain.hpp"

namespace nb = nanobind;
using namespace serpenoid;

namespace {

constexpr std::size_t kColumns = 8;  // ct cn ft0 fn0, ct and ft0 backwards, rolling, breakaway

std::vector<LabLink> listed(Table links) {
    if (links.shape(0) < 2 || links.shape(1) != kColumns)
        throw nb::value_error("links must be (n, 8), two or more of them");
    std::vector<LabLink> list;
    for (std::size_t i = 0; i < links.shape(0); ++i) {
        const double* v = links.data() + kColumns * i;
        list.push_back({{{v[0], v[2], v[4], v[5]}, {v[1], v[3]}}, v[6], v[7]});
    }
    return list;
}

void check_joints(const LabChain& chain, std::size_t count) {
    if (count != static_cast<std::size_t>(chain.joints()))
        throw nb::value_error("one angle a joint");
}

// Let the joints follow rows of angles (K, n - 1), one each `frame` s. States (K, n + 2) at their
// ends: x, y of the centre, angles of all links; fewer rows where a step had no solution.
Array follow(LabChain& c, Table rows, double frame, double h) {
    const std::size_t joints = rows.shape(1), count = rows.shape(0), width = joints + 3;
    check_joints(c, joints);
    std::vector<double> states;
    std::size_t done = 0;
    {
        nb::gil_scoped_release release;
        for (; done < count; ++done) {
            const double* const row = rows.data() + done * joints;
            if (!c.follow({row, row + joints}, frame, h)) break;
            const auto place = c.state();
            const auto angles = c.angles();
            states.insert(states.end(), place.begin(), place.begin() + 2);
            states.insert(states.end(), angles.begin(), angles.end());
        }
    }
    return to_numpy(std::move(states), {done, width});
}

}  // namespace

void bind_lab(nb::module_& m) {
    nb::class_<LabChain>(m, "LabChain")
        .def(
            "__init__",
            [](LabChain* self, double mass, double length, double inertia, Table links,
               std::optional<Servo> servo) {
                const int n = static_cast<int>(links.shape(0));
                new (self) LabChain({n, mass, length / 2, inertia}, listed(links), servo);
            },
            nb::arg("mass_kg"), nb::arg("length_m"), nb::arg("inertia_kg_m2"), nb::arg("links"),
            nb::arg("servo") = nb::none())
        .def("place", &LabChain::place)
        .def("set_joints",
             [](LabChain& c, const std::vector<double>& angle) {
                 check_joints(c, angle.size());
                 c.set_joints(angle);
             })
        .def("aim",
             [](LabChain& c, const std::vector<double>& angle, double rate) {
                 check_joints(c, angle.size());
                 c.aim(angle, rate);
             })
        .def("set_slope", &LabChain::set_slope)
        .def("set_ground_velocity", &LabChain::set_ground_velocity)
        .def("guide", &LabChain::guide)
        .def("advance", &LabChain::advance, nb::call_guard<nb::gil_scoped_release>())
        .def("follow", &follow)
        .def_prop_ro("state", &LabChain::state)
        .def_prop_ro("kinetic_j", &LabChain::kinetic)
        .def_prop_ro("work_j", &LabChain::work)
        .def_prop_ro("places", &LabChain::places);
}
