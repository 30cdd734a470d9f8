// The only file of the core that knows Python: exposes the simulator as serpenoid._core.
//
// The package checks every value before it comes here; these functions are not a public interface.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "periodic/sweep.hpp"
#include "python/core_model.hpp"
#include "run/evaluate.hpp"
#include "run/simulation.hpp"
#include "scene/energy_ledger.hpp"

namespace nb = nanobind;
using namespace serpenoid;

void bind_firmware(nb::module_& m);  // bind_firmware.cpp
void bind_servos(nb::module_& m);    // bind_servos.cpp
void bind_lab(nb::module_& m);       // bind_lab.cpp

namespace {

SteadyState steady(const Model& m, double rtol, bool powers) {
    return steady_state(m, {rtol, powers});
}

// Solve with Ctrl-C and progress coming through; solve(keep_running) fills the table.
template <class Solve>
void with_progress(const nb::object& progress, Solve&& solve) {
    bool stopped = false;  // with the Python error set
    const auto keep_running = [&](long gaits) {
        nb::gil_scoped_acquire acquire;
        stopped = PyErr_CheckSignals() != 0;
        if (stopped || progress.is_none() || gaits == 0) return !stopped;
        try {
            progress(gaits);
        } catch (nb::python_error& error) {
            error.restore();
            stopped = true;
        }
        return !stopped;
    };
    {
        nb::gil_scoped_release release;
        solve(keep_running);
    }
    if (stopped) throw nb::python_error();
}

// Periodic states of all models at all rates, (models, rates, kSweepColumns).
Array sweep(const std::vector<Model>& models, std::vector<double> omegas, double rtol, bool powers,
            int threads, nb::object progress, bool rough) {
    std::vector<double> result(models.size() * omegas.size() * kSweepColumns);
    with_progress(progress, [&](const auto& keep_running) {
        const SteadyOptions options{rtol, powers, rough};
        sweep_shapes(models, omegas, options, threads, keep_running, result.data());
    });
    return to_numpy(std::move(result), {models.size(), omegas.size(), kSweepColumns});
}

// Periodic states of models that are all like `middle`.
std::vector<SteadyState> solve_neighbours(const Model& middle, const std::vector<Model>& models,
                                          double rtol, bool powers, int threads, bool rough,
                                          const std::vector<Vec3>& starts) {
    std::vector<SteadyState> states;
    with_progress(nb::none(), [&](const auto& keep_running) {
        states = neighbours(middle, models, {rtol, powers, rough}, threads, keep_running, starts);
    });
    return states;
}

nb::dict evaluate_links(RunRequest& request, Vector links, Vector per_joint) {
    request.start.assign(links.data(), links.data() + links.size());
    Chain chain = start_chain(request);
    Joints joints(request.robot.n);
    if (request.drive == Drive::torque)
        joints.T.assign(per_joint.data(), per_joint.data() + per_joint.size());
    evaluate(request, per_joint.data(), chain, joints);
    nb::dict result;
    const std::pair<const char*, std::vector<double>*> parts[] = {
        {"ax", &chain.ax},        {"ay", &chain.ay},           {"alpha", &chain.alpha},
        {"fx", &chain.fx},        {"fy", &chain.fy},           {"joint_fx", &joints.Fx},
        {"joint_fy", &joints.Fy}, {"joint_torque", &joints.T},
    };
    for (const auto& [name, values] : parts) {
        const std::size_t size = values->size();
        result[name] = to_numpy(std::move(*values), {size});
    }
    return result;
}

void set_torque_function(RunRequest& request, nb::callable f) {
    request.torque = [f, n = request.robot.n](double t, double* torque) {
        nb::gil_scoped_acquire acquire;
        std::copy_n(nb::cast<Vector>(f(t)).data(), n - 1, torque);
    };
}

// Let Ctrl-C through, and tell how far the run is.
bool keep_running(const nb::object& progress, double t) {
    nb::gil_scoped_acquire acquire;
    if (PyErr_CheckSignals() != 0) throw nb::python_error();
    if (!progress.is_none()) progress(t);
    return true;
}

nb::dict run_scene(RunRequest& request, Vector start, nb::object progress) {
    request.start.assign(start.data(), start.data() + start.size());
    request.keep_running = [&](double t) { return keep_running(progress, t); };
    RunResult r;
    {
        nb::gil_scoped_release release;
        r = simulate(request);
    }
    const std::size_t T = r.t.size();
    nb::dict result;
    const std::pair<const char*, std::vector<double>*> parts[] = {
        {"x_m", &r.x},
        {"y_m", &r.y},
        {"theta_rad", &r.theta},
        {"vx_m_s", &r.vx},
        {"vy_m_s", &r.vy},
        {"omega_rad_s", &r.omega},
        {"joint_force_x_n", &r.joint_fx},
        {"joint_force_y_n", &r.joint_fy},
        {"joint_torque_nm", &r.joint_torque},
        {"friction_x_n", &r.friction_x},
        {"friction_y_n", &r.friction_y},
        {"energy_j", &r.energy},
    };
    for (const auto& [name, values] : parts) {
        const std::size_t columns = values->size() / T;
        result[name] = to_numpy(std::move(*values), {values->empty() ? 0 : T, columns});
    }
    result["t_s"] = to_numpy(std::move(r.t), {T});
    result["failed_at"] = r.failed_at;
    result["why"] = r.why;
    result["steps"] = r.steps;
    result["local_error"] = r.error;
    return result;
}

void choose(RunRequest& request, const std::string& formulation, const std::string& drive,
            const std::string& method) {
    request.formulation =
        formulation == "implicit" ? Formulation::implicit : Formulation::explicit_;
    request.drive = drive == "angle"    ? Drive::angle
                    : drive == "torque" ? Drive::torque
                                        : Drive::servo;
    request.method = method_kind(method);
}

// Joints count from 1 at the tail; the locked ones with their angles.
void set_faults(RunRequest& request, const std::vector<int>& limp,
                const std::map<int, double>& locked) {
    request.faults.assign(request.robot.n - 1, Fault::none);
    request.locked_rad.assign(request.robot.n - 1, 0);
    for (const int joint : limp) request.faults[joint - 1] = Fault::limp;
    for (const auto& [joint, angle] : locked) {
        request.faults[joint - 1] = Fault::locked;
        request.locked_rad[joint - 1] = angle;
    }
}

nb::list method_table() {
    nb::list rows;
    for (const MethodKind& k : kMethods) {
        nb::dict row;
        row["name"] = k.name;
        row["formulations"] = k.formulations;
        row["adaptive"] = k.adaptive;
        row["laws"] = k.laws;
        row["faults"] = k.faults;
        rows.append(row);
    }
    return rows;
}

void bind_run(nb::module_& m) {
    nb::class_<RunRequest> request(m, "RunRequest");
    request
        .def("__init__",
             [](RunRequest* self, const Model& model) {
                 new (self) RunRequest;
                 self->robot = model.robot;
                 self->ground = model.ground;
                 self->gait = model.gait;
             })
        .def("choose", &choose)
        .def("set_faults", &set_faults)
        .def_rw("max_steps", &RunRequest::max_steps)
        .def_rw("record_joints", &RunRequest::record_joints)
        .def_rw("record_friction", &RunRequest::record_friction)
        .def_rw("record_energy", &RunRequest::record_energy)
        .def("set_slope",
             [](RunRequest& request, double gx, double gy) { request.slope = {gx, gy}; })
        .def_rw("servo", &RunRequest::servo)
        .def("set_torque_function", &set_torque_function)
        .def("set_torque_table",
             [](RunRequest& request, std::vector<double> t, std::vector<double> T) {
                 request.table = {std::move(t), std::move(T)};
             });
    std::vector<std::string> names;
    each_scene_field([&](const char* name, auto get) {
        using Value = std::remove_reference_t<decltype(get(std::declval<RunRequest&>()))>;
        names.push_back(name);
        request.def_prop_rw(
            name, [get](RunRequest& request) { return get(request); },
            [get](RunRequest& request, Value value) { get(request) = value; });
    });
    m.attr("SCENE_FIELDS") = nb::tuple(nb::cast(names));
    m.def("run", &run_scene, nb::arg(), nb::arg(), nb::arg().none());
    m.def("evaluate", &evaluate_links);
    m.def("method_table", &method_table);
}

// So few numbers are had sooner than an array of them.
template <std::size_t N>
nb::typed<nb::tuple, double, nb::ellipsis> in_tuple(const std::array<double, N>& v) {
    return [&]<std::size_t... I>(std::index_sequence<I...>) {
        return nb::borrow<nb::typed<nb::tuple, double, nb::ellipsis>>(nb::make_tuple(v[I]...));
    }(std::make_index_sequence<N>());
}

}  // namespace

NB_MODULE(_core, m) {
    // A run that ends in an error leaves frames that hold a board: no leak, and no news to a user.
    nb::set_leak_warnings(false);
    m.doc() = "Compiled core of serpenoid; use the package's own functions instead.";
#ifdef __clang__
    m.attr("compiler") = __VERSION__;  // "Clang ..."
#elif defined(__GNUC__)
    m.attr("compiler") = "GCC " __VERSION__;
#else
    m.attr("compiler") = "MSVC";
#endif
    nb::class_<Model>(m, "Model")
        .def("__init__",
             [](Model* self, int n, double mass, double half_length, double inertia, double ct,
                double cn, double ft0, double fn0, double ct_back, double ft0_back, double alpha,
                double beta, double omega, double offset) {
                 new (self) Model{{n, mass, half_length, inertia},
                                  {{ct, ft0, ct_back, ft0_back}, {cn, fn0}},
                                  {alpha, beta, omega, offset}};
             })
        .def("bent",
             [](const Model& model, double alpha, double beta) {
                 Model bent_model = model;
                 bent_model.gait.alpha = alpha;
                 bent_model.gait.beta = beta;
                 return bent_model;
             })
        .def("set_joints", [](Model& model, Vector gain, Vector shift) {
            model.gait.gain.assign(gain.data(), gain.data() + gain.shape(0));
            model.gait.shift.assign(shift.data(), shift.data() + shift.shape(0));
        });
    nb::class_<SteadyState>(m, "SteadyState")
        .def_ro("speed", &SteadyState::speed)
        .def_ro("chord", &SteadyState::chord)
        .def_ro("power", &SteadyState::power)
        .def_ro("abs_power", &SteadyState::abs_power)
        .def_ro("positive_power", &SteadyState::positive_power)
        .def_ro("turn", &SteadyState::turn)
        .def_ro("direction", &SteadyState::direction)
        .def_ro("speed_error", &SteadyState::speed_error)
        .def_ro("power_error", &SteadyState::power_error)
        .def_ro("positive_power_error", &SteadyState::positive_power_error)
        .def_ro("turn_error", &SteadyState::turn_error)
        .def_ro("log_largest_multiplier", &SteadyState::log_largest_multiplier)
        .def_ro("log_multiplier_error", &SteadyState::log_multiplier_error)
        .def_ro("converged", &SteadyState::converged)
        .def_prop_ro("start", [](const SteadyState& s) { return in_tuple(s.start); })
        .def_prop_ro("monodromy", [](const SteadyState& s) { return in_tuple(s.monodromy); });
    m.def("steady", &steady, nb::call_guard<nb::gil_scoped_release>());
    m.attr("SPEED_FLOOR") = kSpeedFloor;
    m.def("neighbours", &solve_neighbours, nb::arg(), nb::arg(), nb::arg(), nb::arg(), nb::arg(),
          nb::arg("rough") = false, nb::arg("starts") = std::vector<Vec3>{});
    m.def("sweep", &sweep, nb::arg(), nb::arg(), nb::arg(), nb::arg(), nb::arg(), nb::arg().none(),
          nb::arg("rough") = false);
    bind_servos(m);
    bind_run(m);
    bind_firmware(m);
    bind_lab(m);
}
