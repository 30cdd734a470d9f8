// The only file of the core that knows Python: exposes the simulator as serpenoid._core.
//
// The package checks every value before it comes here; these functions are not a public interface.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/complex.h>
#include <nanobind/stl/string.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "simulation.hpp"
#include "steady_dry.hpp"
#include "steady_viscous.hpp"

namespace nb = nanobind;
using namespace serpenoid;

void bind_firmware(nb::module_& m);  // bindings_firmware.cpp
void bind_lanes(nb::module_& m);     // bindings_lanes.cpp

namespace {

using Vector = nb::ndarray<const double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Array = nb::ndarray<nb::numpy, double>;

// Hand a vector's memory to NumPy.
Array to_numpy(std::vector<double>&& values, std::initializer_list<std::size_t> shape) {
    auto owner = std::make_unique<std::vector<double>>(std::move(values));
    double* data = owner->data();
    nb::capsule free(owner.release(),
                     [](void* p) noexcept { delete static_cast<std::vector<double>*>(p); });
    return Array(data, shape, free);
}

struct Model {
    Robot robot;
    Ground ground;
    Gait gait;
};

SteadyState steady(const Model& m, double rtol, bool powers, int max_elements) {
    const SteadyOptions options{rtol, powers, max_elements};
    if (m.ground.dry()) return steady_dry(m.robot, m.ground, m.gait, options);
    return SteadyViscous(m.robot, m.ground, m.gait).solve(m.gait.omega, options);
}

// One row for many rates at one shape: speed, the three powers, 1.0 where converged.
Array steady_row(const Model& m, Vector omegas, double rtol, bool powers, int max_elements) {
    const std::size_t count = omegas.shape(0);
    std::vector<double> out(5 * count);
    {
        nb::gil_scoped_release release;
        const SteadyOptions options{rtol, powers, max_elements};
        SteadyViscous viscous(m.robot, m.ground, m.gait);
        for (std::size_t i = 0; i < count; ++i) {
            Gait gait = m.gait;
            gait.omega = omegas.data()[i];
            const SteadyState s = m.ground.dry() ? steady_dry(m.robot, m.ground, gait, options)
                                                 : viscous.solve(gait.omega, options);
            const double row[5] = {s.speed, s.power, s.abs_power, s.positive_power,
                                   s.converged ? 1.0 : 0.0};
            for (int k = 0; k < 5; ++k) out[k * count + i] = row[k];
        }
    }
    return to_numpy(std::move(out), {5, count});
}

RunRequest request(const Model& m, bool implicit, bool torque, double k, double c,
                   double smoothing) {
    RunRequest q;
    q.robot = m.robot, q.ground = m.ground, q.gait = m.gait;
    q.formulation = implicit ? Formulation::implicit : Formulation::explicit_;
    q.drive = torque ? Drive::torque : Drive::angle;
    q.spring = {k, c};
    q.smoothing = smoothing;
    return q;
}

nb::dict evaluate_links(const Model& m, bool implicit, bool torque, double k, double c,
                        double smoothing, Vector links, Vector drive) {
    const RunRequest q = request(m, implicit, torque, k, c, smoothing);
    const std::size_t n = m.robot.n;
    Chain chain(m.robot.n);
    Joints joints(m.robot.n);
    std::vector<double>* part[6] = {&chain.x,  &chain.y,  &chain.theta,
                                    &chain.vx, &chain.vy, &chain.omega};
    for (int p = 0; p < 6; ++p) std::copy_n(links.data() + p * n, n, part[p]->begin());
    if (torque) std::copy_n(drive.data(), n - 1, joints.T.begin());
    evaluate(q, drive.data(), chain, joints);
    nb::dict out;
    out["ax"] = to_numpy(std::move(chain.ax), {n});
    out["ay"] = to_numpy(std::move(chain.ay), {n});
    out["alpha"] = to_numpy(std::move(chain.alpha), {n});
    out["fx"] = to_numpy(std::move(chain.fx), {n});
    out["fy"] = to_numpy(std::move(chain.fy), {n});
    out["joint_fx"] = to_numpy(std::move(joints.Fx), {n - 1});
    out["joint_fy"] = to_numpy(std::move(joints.Fy), {n - 1});
    out["joint_torque"] = to_numpy(std::move(joints.T), {n - 1});
    return out;
}

TorqueFunction torque_of(nb::object f, int n) {
    return [f, n](double t, double* to) {
        nb::gil_scoped_acquire acquire;
        const Vector values = nb::cast<Vector>(f(t));
        if (values.shape(0) != static_cast<std::size_t>(n - 1))
            throw nb::value_error("the torque function must return one value a joint");
        std::copy_n(values.data(), n - 1, to);
    };
}

nb::dict run(const Model& m, bool implicit, nb::object torque, bool nonsmooth, double k, double c,
             double smoothing, double dt, double duration, long steps, long every,
             bool record_joints, Vector start) {
    RunRequest q = request(m, implicit, !torque.is_none(), k, c, smoothing);
    q.method = nonsmooth ? Method::nonsmooth : Method::rk4;
    q.dt = dt, q.duration = duration, q.steps = steps, q.every = every,
    q.record_joints = record_joints;
    q.start.assign(start.data(), start.data() + start.shape(0));
    if (!torque.is_none()) q.torque = torque_of(torque, m.robot.n);
    RunResult r;
    {
        nb::gil_scoped_release release;
        r = simulate(q);
    }
    const std::size_t T = r.t.size(), n = m.robot.n;
    nb::dict out;
    out["failed_at"] = r.failed_at;
    out["t_s"] = to_numpy(std::move(r.t), {T});
    out["x_m"] = to_numpy(std::move(r.x), {T, n});
    out["y_m"] = to_numpy(std::move(r.y), {T, n});
    out["theta_rad"] = to_numpy(std::move(r.theta), {T, n});
    out["vx_m_s"] = to_numpy(std::move(r.vx), {T, n});
    out["vy_m_s"] = to_numpy(std::move(r.vy), {T, n});
    out["omega_rad_s"] = to_numpy(std::move(r.omega), {T, n});
    const std::size_t J = r.joint_fx.empty() ? 0 : T;
    out["joint_fx_n"] = to_numpy(std::move(r.joint_fx), {J, n - 1});
    out["joint_fy_n"] = to_numpy(std::move(r.joint_fy), {J, n - 1});
    out["joint_torque_nm"] = to_numpy(std::move(r.joint_torque), {J, n - 1});
    return out;
}

Array three(const Vec3& v) { return to_numpy({v.begin(), v.end()}, {3}); }

}  // namespace

NB_MODULE(_core, m) {
    m.doc() = "Compiled core of serpenoid; use the package's own functions instead.";
    nb::class_<Model>(m, "Model")
        .def("__init__", [](Model* self, int n, double mass, double half_length, double inertia,
                            double ct, double cn, double ft0, double fn0, double alpha, double beta,
                            double omega, double offset) {
            new (self) Model{
                {n, mass, half_length, inertia}, {ct, cn, ft0, fn0}, {alpha, beta, omega, offset}};
        });
    nb::class_<SteadyState>(m, "SteadyState")
        .def_ro("speed", &SteadyState::speed)
        .def_ro("power", &SteadyState::power)
        .def_ro("abs_power", &SteadyState::abs_power)
        .def_ro("positive_power", &SteadyState::positive_power)
        .def_ro("turn", &SteadyState::turn)
        .def_ro("direction", &SteadyState::direction)
        .def_ro("speed_error", &SteadyState::speed_error)
        .def_ro("power_error", &SteadyState::power_error)
        .def_ro("elements", &SteadyState::elements)
        .def_ro("iterations", &SteadyState::iterations)
        .def_ro("converged", &SteadyState::converged)
        .def_prop_ro(
            "start", [](const SteadyState& s) { return three(s.start); }, nb::rv_policy::move)
        .def_prop_ro(
            "monodromy",
            [](const SteadyState& s) {
                return to_numpy({s.monodromy.begin(), s.monodromy.end()}, {3, 3});
            },
            nb::rv_policy::move);
    m.def("steady", &steady, nb::call_guard<nb::gil_scoped_release>());
    m.def("steady_row", &steady_row);
    m.def("evaluate", &evaluate_links);
    m.def("run", &run, nb::arg(), nb::arg(), nb::arg().none(), nb::arg(), nb::arg(), nb::arg(),
          nb::arg(), nb::arg(), nb::arg(), nb::arg(), nb::arg(), nb::arg(), nb::arg());
    bind_firmware(m);
    bind_lanes(m);
}
