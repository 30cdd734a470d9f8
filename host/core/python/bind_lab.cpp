// The lab's free chain for Python, as serpenoid._core.FreeChain.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "lab/driven_chain.hpp"
#include "lab/free_chain.hpp"

namespace nb = nanobind;
using namespace serpenoid;

namespace {

using Rows = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
constexpr std::size_t kColumns = 8;  // ct cn ft0 fn0, ct and ft0 backwards, rolling, breakaway

std::vector<LabLink> listed(Rows links) {
    if (links.shape(0) < 2 || links.shape(1) != kColumns)
        throw nb::value_error("links must be (n, 8), two or more of them");
    std::vector<LabLink> list;
    for (std::size_t i = 0; i < links.shape(0); ++i) {
        const double* v = links.data() + kColumns * i;
        list.push_back({{v[0], v[1], v[2], v[3], v[4], v[5]}, v[6], v[7]});
    }
    return list;
}

Robot body(double mass, double length, double inertia, Rows links) {
    return {static_cast<int>(links.shape(0)), mass, length / 2, inertia};
}

void check_joints(const FreeChain& chain, const std::vector<double>& angle) {
    if (angle.size() != chain.joints().size()) throw nb::value_error("one angle a joint");
}

void check_time(double duration, double h) {
    if (!(duration > 0 && h > 0 && duration / h < 1e9))
        throw nb::value_error(
            "duration and step must be above 0, and not a thousand million steps");
}

// Lead the joints through rows of angles (K, n - 1), one each `frame` s. States (K, 6) at their
// ends: x, y, theta, vx, vy, w; fewer rows where a step had no solution.
nb::ndarray<nb::numpy, double> follow(FreeChain& c, Rows rows, double frame, double h) {
    const std::size_t joints = c.joints().size(), count = rows.shape(0);
    if (rows.shape(1) != joints) throw nb::value_error("one angle a joint");
    check_time(frame, h);
    auto out = std::make_unique<double[]>(6 * count + 1);
    std::size_t done = 0;
    {
        nb::gil_scoped_release release;
        std::vector<double> to(joints);
        for (; done < count; ++done) {
            std::copy_n(rows.data() + done * joints, joints, to.begin());
            if (!c.lead(to, frame, h)) break;
            const auto now = c.state();
            std::copy_n(now.begin(), 6, &out[6 * done]);
        }
    }
    double* data = out.release();
    nb::capsule free(data, [](void* p) noexcept { delete[] static_cast<double*>(p); });
    return {data, {done, 6}, free};
}

// Hold each row of setpoints (K, n - 1) for a frame of `steps` steps. States (K, n + 2) at the
// frames' ends: x, y of the centre, angles of all links; fewer rows where a step failed.
nb::ndarray<nb::numpy, double> drive(DrivenChain& c, Rows rows, int steps) {
    const std::size_t joints = rows.shape(1), count = rows.shape(0), width = joints + 3;
    if (joints != static_cast<std::size_t>(c.joints())) throw nb::value_error("one angle a joint");
    if (steps < 1) throw nb::value_error("steps must be 1 or more");
    auto out = std::make_unique<double[]>(width * count + 1);
    std::size_t done = 0;
    {
        nb::gil_scoped_release release;
        std::vector<double> to(joints);
        for (; done < count; ++done) {
            std::copy_n(rows.data() + done * joints, joints, to.begin());
            if (!c.frame(to, steps)) break;
            c.state(&out[width * done]);
        }
    }
    double* data = out.release();
    nb::capsule free(data, [](void* p) noexcept { delete[] static_cast<double*>(p); });
    return {data, {done, width}, free};
}

void bind_driven(nb::module_& m) {
    nb::class_<DrivenChain>(m, "DrivenChain")
        .def("__init__",
             [](DrivenChain* self, double mass, double length, double inertia, Rows links,
                const Servo& servo) {
                 auto list = listed(links);
                 new (self) DrivenChain(body(mass, length, inertia, links), list, servo);
             })
        .def("place",
             [](DrivenChain& c, double theta, const std::vector<double>& joints) {
                 if (joints.size() != static_cast<std::size_t>(c.joints()))
                     throw nb::value_error("one angle a joint");
                 c.place(theta, joints);
             })
        .def("set_slope", &DrivenChain::set_slope)
        .def("drive", &drive)
        .def_prop_ro("kinetic_j", &DrivenChain::kinetic)
        .def_prop_ro("work_j", &DrivenChain::work);
}

}  // namespace

void bind_lab(nb::module_& m) {
    bind_driven(m);
    nb::class_<FreeChain>(m, "FreeChain")
        .def("__init__",
             [](FreeChain* self, double mass, double length, double inertia, Rows links) {
                 new (self) FreeChain(body(mass, length, inertia, links), listed(links));
             })
        .def("place", &FreeChain::place)
        .def("set_joints",
             [](FreeChain& c, const std::vector<double>& angle) {
                 check_joints(c, angle), c.set_joints(angle);
             })
        .def("aim", [](FreeChain& c, const std::vector<double>& angle,
                       double rate) { check_joints(c, angle), c.aim(angle, rate); })
        .def("set_slope", &FreeChain::set_slope)
        .def("set_ground_velocity", &FreeChain::set_ground_velocity)
        .def("guide", &FreeChain::guide)
        .def("advance",
             [](FreeChain& c, double duration, double h) {
                 check_time(duration, h);
                 nb::gil_scoped_release release;
                 return c.advance(duration, h);
             })
        .def("follow", &follow)
        .def_prop_ro("state", &FreeChain::state)
        .def_prop_ro("joints", &FreeChain::joints)
        .def_prop_ro("kinetic_j", &FreeChain::kinetic)
        .def_prop_ro("places", &FreeChain::places);
}
