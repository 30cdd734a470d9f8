// The fixed-point gait against double precision: phase over a day, conversions of units, pulses.
// test_gait_in_python.py tests the formula of the gait.
#include <cmath>
#include <random>
#include <vector>

#include "doctest_main.h"
#include "gait.h"
#include "pulse.h"

using namespace firmware;

namespace {

const double kPi = 3.14159265358979323846;
const double kTurn = 4294967296.0;

double degrees_from_q14(int16_t angle_q14) { return angle_q14 / 16384.0 * 180.0 / kPi; }

}  // namespace

// The step of a frame of 20 ms is rounded by at most half of 1 part in 5.87e10. After a day at
// 30 rad/s (412 530 turns) the phase is then wrong by at most 3.5e-6 turns, or 1.3e-3 degrees. An
// error of 1 ppm, the limit, would be 0.4 turns.
TEST_CASE("after a day the phase is the rate times the time") {
    for (const int32_t omega : {10000, 1798700, 5000000, 6283185, 10138000, 30000000}) {
        for (const uint16_t frame_us : std::vector<uint16_t>{20000, 16670, 7590, 3290}) {
            for (const uint64_t frames : {1, 12345, 4320000}) {
                const double turns = omega * 1e-6 * frame_us * 1e-6 * frames / (2 * kPi);
                const uint64_t phase_q64 = phase_step(omega, frame_us) * frames;
                const double phase = static_cast<double>(phase_q64 >> 32) / kTurn;
                CHECK(std::fabs(std::remainder(phase - turns, 1)) < 4e-6);
            }
        }
    }
}

TEST_CASE("angles are converted to the nearest value, from and to the protocol's units") {
    std::mt19937 random(3);
    std::uniform_int_distribution<int32_t> angle_udeg(-114591000, 114591000);
    for (int k = 0; k < 10000; ++k) {
        const int32_t udeg = angle_udeg(random);
        const double q30 = udeg * 1e-6 * kPi / 180 * 1073741824.0;
        // 0.5 by rounding, and a factor with an error of 2e-10, for up to 2³¹.
        CHECK(std::fabs(q30_from_udeg(udeg) - q30) < 1.0);
        CHECK(std::fabs(q31_turn_from_udeg(udeg) - udeg / 360e6 * 2147483648.0) < 1.0);
        const int16_t q14 = q14_from_q30(q30_from_udeg(udeg));
        // 0.5 by rounding, and a factor with an error of 8e-6, for up to 11459.
        CHECK(std::fabs(cdeg_from_q14(q14) - degrees_from_q14(q14) * 100) <= 0.6);
    }
    CHECK(q31_turn_from_udeg(180000000) == 1 << 30);
}

TEST_CASE("the phase in thousandths of a degree is below 360 degrees") {
    CHECK(mdeg_from_phase(0) == 0);
    CHECK(mdeg_from_phase(0x40000000U) == 90000);
    CHECK(mdeg_from_phase(0xFFFFFFFFU) == 359999);
}

TEST_CASE("a pulse is the centre plus or minus scale times angle, to the nearest µs") {
    std::mt19937 random(11);
    std::uniform_int_distribution<int> angle(-32767, 32767), scale(300 * 32, 1200 * 32);
    for (int k = 0; k < 10000; ++k) {
        Trim trim = {1512, static_cast<uint16_t>(scale(random)), 1, -25736, 25736};
        const int16_t q14 = static_cast<int16_t>(angle(random));
        const double swing = trim.scale_q5_us_per_rad / 32.0 * q14 / 16384.0;
        CHECK(std::fabs(pulse_us(trim, q14) - (1512 + swing)) <= 0.5);
        trim.direction = -1;
        CHECK(std::fabs(pulse_us(trim, q14) - (1512 - swing)) <= 0.5);
    }
}
