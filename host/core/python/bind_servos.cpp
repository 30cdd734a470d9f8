// What Python has of servos: their numbers, and gaits that they drive.
#include <nanobind/nanobind.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <chrono>
#include <string>
#include <vector>

#include "python/core_model.hpp"
#include "servos/servo_gait.hpp"

namespace nb = nanobind;
using namespace serpenoid;

namespace {

ServoGaitState servo_gait_of(const Model& m, const Servo& servo, const Vec3& start,
                             const Mat3& monodromy, double longest, bool rough, double slow,
                             const nb::object& progress) {
    using Clock = std::chrono::steady_clock;
    constexpr auto kEvery = std::chrono::milliseconds(50);
    auto last_call = Clock::now();
    const auto report = [&](double done_cycles, double all_cycles) {
        if (Clock::now() - last_call < kEvery) return;
        const nb::gil_scoped_acquire acquire;
        if (PyErr_CheckSignals() != 0) throw nb::python_error();
        if (!progress.is_none()) progress(done_cycles, all_cycles);
        last_call = Clock::now();
    };
    const nb::gil_scoped_release release;
    return servo_gait(m.robot, m.ground, m.gait, servo, start, monodromy, longest, rough, slow,
                      report);
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
