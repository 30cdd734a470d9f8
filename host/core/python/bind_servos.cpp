// What Python has of servos: their numbers, and gaits that they drive.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "python/core_model.hpp"
#include "servos/bench_joint.hpp"
#include "servos/servo_gait.hpp"

namespace nb = nanobind;
using namespace serpenoid;

namespace {

// What a joint on a bench has, under the names that Python has for it.
template <class Visit>
void each_bench_field(const Visit& field) {
    each_servo_field([&](const char* name, double Servo::* get) {
        field(name, [get](BenchJoint& joint) -> double& { return joint.servo.*get; });
    });
    const auto bench = [&](const char* name, double BenchJoint::* get) {
        field(name, [get](BenchJoint& joint) -> double& { return joint.*get; });
    };
    bench("load_inertia_kg_m2", &BenchJoint::load_inertia);
    bench("gravity_nm", &BenchJoint::gravity);
    bench("gravity_angle_rad", &BenchJoint::gravity_angle);
    bench("gain", &BenchJoint::gain);
    bench("start_rad", &BenchJoint::start);
}

std::size_t count_of_bench_fields() {
    std::size_t count = 0;
    each_bench_field([&](const char*, auto) { ++count; });
    return count;
}

ServoGaitState servo_gait_of(const Model& m, const Servo& servo, const Vec3& start,
                             const Mat3& monodromy, double longest, bool rough, double slow,
                             const nb::object& progress) {
    using Clock = std::chrono::steady_clock;
    auto last_call = Clock::now();
    const auto report = [&](double done_cycles, double all_cycles) {
        if (Clock::now() - last_call < std::chrono::milliseconds(50)) return;
        const nb::gil_scoped_acquire acquire;
        if (PyErr_CheckSignals() != 0) throw nb::python_error();
        if (!progress.is_none()) progress(done_cycles, all_cycles);
        last_call = Clock::now();
    };
    const nb::gil_scoped_release release;
    return servo_gait(m.robot, m.ground, m.gait, servo, start, monodromy, longest, rough, slow,
                      report);
}

// Angles (K, T) of joints: rows of the fields that BENCH_FIELDS names, and the times at which each
// setpoint takes effect on each of them.
Array angles_on_bench(Table joints, Vector setpoints, Table effect_times, Vector times) {
    const std::size_t count = joints.shape(0), rows = times.shape(0), steps = setpoints.shape(0);
    const std::size_t fields = count_of_bench_fields();
    if (joints.shape(1) != fields || effect_times.shape(0) != count ||
        effect_times.shape(1) != steps || rows == 0 || steps == 0)
        throw nb::value_error("one row of fields and one of times for each joint");
    std::vector<double> angles(count * rows);
    {
        nb::gil_scoped_release release;
        for (std::size_t k = 0; k < count; ++k) {
            BenchJoint joint;
            const double* value = joints.data() + k * fields;
            each_bench_field([&](const char*, auto field) { field(joint) = *value++; });
            // A quick rotor comes to speed in ten steps of 1 ms.
            bench_angles(joint, {setpoints.data(), steps}, {effect_times.data() + k * steps, steps},
                         {times.data(), rows}, 1e-3, {&angles[k * rows], rows});
        }
    }
    return to_numpy(std::move(angles), {count, rows});
}

}  // namespace

void bind_servos(nb::module_& m) {
    nb::class_<Servo> servo(m, "Servo");
    servo.def(nb::init<>());
    std::vector<std::string> names;
    each_servo_field([&](const char* name, double Servo::* field) {
        names.push_back(name);
        servo.def_rw(name, field);
    });
    m.attr("SERVO_FIELDS") = nb::tuple(nb::cast(names));
    std::vector<std::string> bench_names;
    each_bench_field([&](const char* name, auto) { bench_names.emplace_back(name); });
    m.attr("BENCH_FIELDS") = nb::tuple(nb::cast(bench_names));
    m.def("bench_angles", &angles_on_bench);
    nb::class_<ServoGaitState>(m, "ServoGaitState")
        .def_ro("speed", &ServoGaitState::speed)
        .def_ro("spread", &ServoGaitState::spread)
        .def_ro("error", &ServoGaitState::error)
        .def_ro("turn", &ServoGaitState::turn)
        .def_ro("power", &ServoGaitState::power)
        .def_ro("amplitude", &ServoGaitState::amplitude)
        .def_ro("lag", &ServoGaitState::lag)
        .def_ro("ripple", &ServoGaitState::ripple)
        .def_ro("gain", &ServoGaitState::gain)
        .def_ro("shift", &ServoGaitState::shift)
        .def_ro("converged", &ServoGaitState::converged)
        .def_ro("hunts", &ServoGaitState::hunts);
    m.def("servo_gait", &servo_gait_of, nb::arg(), nb::arg(), nb::arg(), nb::arg(), nb::arg(),
          nb::arg(), nb::arg(), nb::arg("progress") = nb::none());
}
