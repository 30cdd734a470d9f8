// The firmware's own code for Python, as serpenoid._core.firmware: gait, CRC.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <cmath>
#include <stdexcept>
#include <string>

#include "crc16.h"
#include "gait.h"

namespace nb = nanobind;
using namespace nb::literals;

namespace {

constexpr double kPi = 3.14159265358979323846;

// Radians (or rad/s) to the wire's millionths of degrees (or of rad/s).
int32_t millionths(double value, double limit, const char* name) {
    if (!(std::fabs(value) <= limit)) {
        throw std::invalid_argument(std::string(name) + " is " + std::to_string(value) +
                                    "; the firmware takes a magnitude of at most " +
                                    std::to_string(limit));
    }
    return static_cast<int32_t>(std::llround(value * 1e6));
}

int32_t udeg(double angle_rad, double limit_deg, const char* name) {
    return millionths(angle_rad * 180.0 / kPi, limit_deg, name);
}

using Angles = nb::ndarray<nb::numpy, double, nb::ndim<2>>;

Angles gait_setpoints_rad(double alpha_rad, double beta_rad, double omega_rad_s, double offset_rad,
                          int64_t first_frame, size_t frames, size_t joints) {
    using namespace firmware;
    if (joints > 255) throw std::invalid_argument("the firmware's gait takes at most 255 joints");
    if (!(omega_rad_s >= 0)) throw std::invalid_argument("omega_rad_s must be at least 0");
    const int16_t alpha = q14_from_q30(q30_from_udeg(udeg(alpha_rad, 90, "alpha in degrees")));
    const int16_t offset = q14_from_q30(q30_from_udeg(udeg(offset_rad, 90, "offset in degrees")));
    const int32_t beta = q31_turn_from_udeg(udeg(beta_rad, 180, "beta in degrees"));
    const uint64_t step = phase_step(millionths(omega_rad_s, 50, "omega_rad_s"));
    double* const angles = new double[frames * joints + 1];
    nb::capsule owner(angles, [](void* p) noexcept { delete[] static_cast<double*>(p); });
    uint64_t phase = step * static_cast<uint64_t>(first_frame);
    for (size_t k = 0; k < frames; ++k, phase += step) {
        for (size_t i = 0; i < joints; ++i) {
            const int16_t swing = gait_angle(alpha, beta, static_cast<uint32_t>(phase >> 32),
                                             static_cast<uint8_t>(i));
            angles[k * joints + i] = (offset + swing) / 16384.0;
        }
    }
    return Angles(angles, {frames, joints}, owner);
}

}  // namespace

void bind_firmware(nb::module_& parent) {
    nb::module_ m = parent.def_submodule("firmware", "The code that runs on the board.");
    m.attr("FRAME_S") = 0.02;
    m.attr("JOINTS") = firmware::kJoints;
    m.def("gait_setpoints_rad", &gait_setpoints_rad, "alpha_rad"_a, "beta_rad"_a, "omega_rad_s"_a,
          nb::kw_only(), "offset_rad"_a = 0.0, "first_frame"_a = 0, "frames"_a = 1, "joints"_a = 5,
          "Return the settled gait's setpoints, (frames, joints), radians, one row per 20 ms.\n\n"
          "The phase is 0 at frame 0. Fixed point: within 0.012 degrees of Eq. 57. Raises\n"
          "ValueError for alpha or offset beyond 90 degrees, beta beyond 180, omega beyond 50.");
    m.def(
        "crc16",
        [](nb::bytes data) {
            uint16_t crc = firmware::kCrcStart;
            for (size_t i = 0; i < data.size(); ++i) {
                crc = firmware::crc16_next(crc, static_cast<uint8_t>(data.c_str()[i]));
            }
            return crc;
        },
        "data"_a, "Return CRC-16/IBM-3740 of some bytes, as on the wire.");
}
