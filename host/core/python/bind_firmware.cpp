// The firmware's own code for Python, as serpenoid._core.firmware: gait, protocol, a whole board.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/unique_ptr.h>
#include <nanobind/stl/vector.h>

#include <cmath>
#include <stdexcept>
#include <string>

#include "board/board.hpp"
#include "crc16.h"
#include "drive/firmware_gait.hpp"
#include "error_codes.h"
#include "fields.h"

namespace nb = nanobind;
using namespace nb::literals;
using serpenoid::Board;

namespace {

using Angles = nb::ndarray<nb::numpy, double, nb::ndim<2>>;

Angles gait_setpoints_rad(double alpha_rad, double beta_rad, double omega_rad_s, double offset_rad,
                          int64_t first_frame, size_t frames, size_t joints) {
    const serpenoid::FirmwareGait gait({alpha_rad, beta_rad, omega_rad_s, offset_rad});
    double* const angles = new double[frames * joints + 1];
    nb::capsule owner(angles, [](void* p) noexcept { delete[] static_cast<double*>(p); });
    for (size_t k = 0; k < frames; ++k)
        gait.setpoints(static_cast<uint64_t>(first_frame) + k, angles + k * joints, joints);
    return Angles(angles, {frames, joints}, owner);
}

std::string text(nb::bytes data) { return std::string(data.c_str(), data.size()); }

nb::dict counters(const Board& board) {
    const firmware::Counters& c = board.view().controller().counters();
    nb::dict table;
#define PUT_COUNTER(name) table[#name] = c.name;
    FIRMWARE_COUNTERS(PUT_COUNTER)
#undef PUT_COUNTER
    table["overruns"] = c.overruns;
    table["clipped"] = c.clipped;
    return table;
}

void set_eeprom(Board& board, nb::bytes data) {
    if (data.size() != firmware::VirtualBoard::kEepromBytes) {
        throw std::invalid_argument("the EEPROM has 1024 bytes, not " +
                                    std::to_string(data.size()));
    }
    const uint8_t* const bytes = reinterpret_cast<const uint8_t*>(data.c_str());
    board.activate().eeprom().assign(bytes, bytes + data.size());
}

uint64_t microseconds(double seconds) {
    if (!(seconds >= 0 && seconds <= 1e6)) throw std::invalid_argument("seconds must be 0 to 1e6");
    return static_cast<uint64_t>(std::llround(seconds * 1e6));
}

void bind_board(nb::module_& m) {
    const auto controller = [](const Board& b) -> const firmware::Controller& {
        return b.view().controller();
    };
    nb::class_<Board>(m, "Board",
                      "The firmware's controller on a simulated clock, wire and servos.\n\n"
                      "It must be booted before it is run; the wire has its true pace. joints:\n"
                      "2 to 12.")
        .def(nb::init<uint64_t, int>(), "start_us"_a = 0, "joints"_a = 5)
        .def("boot", &Board::boot, "reset"_a = "power", "first_frame"_a = 0,
             "Start anew with the same EEPROM; what was on the wire is lost.")
        .def(
            "run",
            [](Board& b, double seconds) {
                const uint64_t duration_us = microseconds(seconds);
                nb::gil_scoped_release release;
                b.activate().run(duration_us);
            },
            "seconds"_a, "Let so much of the board's time pass.")
        .def(
            "stall", [](Board& b, double seconds) { b.activate().stall(microseconds(seconds)); },
            "seconds"_a, "Let time pass without the programme running.")
        .def(
            "write", [](Board& b, nb::bytes data) { b.activate().send_to_board(text(data)); },
            "data"_a, "Put bytes on the wire to the board.")
        .def(
            "read",
            [](Board& b) {
                const std::string bytes = b.activate().take_output();
                return nb::bytes(bytes.data(), bytes.size());
            },
            "Return all bytes that have arrived from the board since the last call.")
        .def_prop_rw(
            "eeprom",
            [](Board& b) {
                const std::vector<uint8_t>& bytes = b.activate().eeprom();
                return nb::bytes(bytes.data(), bytes.size());
            },
            &set_eeprom, "All 1024 bytes; change them while it is not running.")
        .def_prop_ro("time_s",
                     [](Board& b) { return static_cast<double>(b.view().now_us()) * 1e-6; })
        .def_prop_ro("state", [=](Board& b) { return firmware::state_name(controller(b).state()); })
        .def_prop_ro("frame", [=](Board& b) { return controller(b).frame_number(); })
        .def_prop_ro("session", [=](Board& b) { return controller(b).session(); })
        .def_prop_ro("counters", &counters, "Counts since boot, by the names of PROTOCOL.md.")
        .def_prop_ro("setpoints_rad", &Board::setpoints_rad, "The joints' setpoints, tail first.")
        .def_prop_ro("pulses_us", &Board::pulses_us,
                     "The pulse width each servo gets, 0 while detached.");
}

nb::list errors() {
    nb::list table;
#define LIST_ERROR(id, number, word, cause, cure) \
    table.append(nb::make_tuple(word, number, cause, cure));
    FIRMWARE_ERRORS(LIST_ERROR)
#undef LIST_ERROR
    return table;
}

nb::dict fields(firmware::Field (*field)(uint8_t), uint8_t count) {
    nb::dict table;
    for (uint8_t i = 0; i < count; ++i) {
        const firmware::Field f = field(i);
        table[f.name] = nb::make_tuple(f.unit, f.low_u / 1e6, f.high_u / 1e6, f.default_u / 1e6);
    }
    return table;
}

}  // namespace

void bind_firmware(nb::module_& parent) {
    nb::module_ m = parent.def_submodule("firmware", "The code that runs on the board.");
    m.attr("FRAME_S") = firmware::kFrameUs * 1e-6;
    m.attr("JOINTS") = SERPENOID_JOINTS;
    m.attr("VERSION") = std::string(firmware::kVersion);
    m.attr("PROTOCOL") = firmware::kProtocol;
    // (word, number, cause, cure), and name -> (unit, low, high, default), as on the board.
    m.attr("ERRORS") = errors();
    m.attr("SETTINGS") = fields(&firmware::setting_field, firmware::kSettingCount);
    m.attr("TRIM") = fields(&firmware::trim_field, firmware::kTrimFieldCount);
    m.attr("GAIT") = fields(&firmware::gait_field, firmware::kGaitFieldCount);
    bind_board(m);
    m.def("gait_setpoints_rad", &gait_setpoints_rad, "alpha_rad"_a, "beta_rad"_a, "omega_rad_s"_a,
          nb::kw_only(), "offset_rad"_a = 0.0, "first_frame"_a = 0, "frames"_a = 1, "joints"_a = 5,
          "Return the settled gait's setpoints, (frames, joints), radians, one row per 20 ms.\n\n"
          "The phase is 0 at frame 0. Fixed point: within 0.012 degrees of Eq. 57, for alpha and\n"
          "offset up to 90 degrees, beta up to 180, omega up to 50, joints up to 255.");
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
