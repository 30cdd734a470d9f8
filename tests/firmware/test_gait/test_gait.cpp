// The fixed-point gait against double precision: formula, phase over a day, conversions, pulses.
#include <cmath>
#include <random>
#include <vector>

#include "doctest_main.h"
#include "gait.h"
#include "golden.h"
#include "pulse.h"
#include "sine.h"

using namespace firmware;

namespace {

const double kPi = 3.14159265358979323846;
const double kTurn = 4294967296.0;

int32_t millionths(const std::string& text) {
    return static_cast<int32_t>(std::lround(std::stod(text) * 1e6));
}

double degrees(int16_t angle_q14) { return angle_q14 / 16384.0 * 180.0 / kPi; }

double setpoint_deg(double alpha, double beta, double offset, uint32_t phase, uint8_t joint) {
    const int16_t alpha_q14 = q14_from_q30(q30_from_udeg(static_cast<int32_t>(alpha * 1e6)));
    const int16_t offset_q14 = q14_from_q30(q30_from_udeg(static_cast<int32_t>(offset * 1e6)));
    const int32_t beta_q31 = q31_turn_from_udeg(static_cast<int32_t>(std::lround(beta * 1e6)));
    return degrees(offset_q14) + degrees(gait_angle(alpha_q14, beta_q31, phase, joint));
}

}  // namespace

// Chord error h²/16 = 3.7e-5, table and product rounding 1.5e-5 each: 7e-5. The cut at 32767 is
// 3e-5, at the crest alone.
TEST_CASE("sine is within 7e-5 of the true one over the whole turn") {
    double worst = 0;
    for (uint64_t p = 0; p < (1ULL << 32); p += 9973) {
        const double truth = std::sin(2 * kPi * static_cast<double>(p) / kTurn);
        worst = std::max(worst, std::fabs(sine_q15(static_cast<uint32_t>(p)) / 32768.0 - truth));
    }
    CHECK(worst < 7e-5);
    CHECK(worst > 1e-6);  // the comparison is not with itself
}

TEST_CASE("sine is odd and symmetric to the bit") {
    std::mt19937 random(7);
    for (int k = 0; k < 100000; ++k) {
        const uint32_t p = static_cast<uint32_t>(random());
        CHECK(sine_q15(p) == -sine_q15(0U - p));
        CHECK(sine_q15(p) == sine_q15(0x80000000U - p));
    }
    CHECK(sine_q15(0) == 0);
    CHECK(sine_q15(0x40000000U) == 32767);
    CHECK(sine_q15(0xC0000000U) == -32767);
}

// 7e-5 of 90 degrees is 0.0063; amplitude, offset and product are each rounded to 0.0035/2: 0.0116.
TEST_CASE("setpoints are within 0.0116 degrees of the golden ones") {
    double worst = 0;
    for (const Row& row : golden("gait.csv")) {
        const double alpha = std::stod(row[0]), beta = std::stod(row[1]),
                     offset = std::stod(row[2]);
        const uint32_t phase = static_cast<uint32_t>(std::stoul(row[3]));
        const uint8_t joint = static_cast<uint8_t>(std::stoi(row[4]) - 1);
        const double error = setpoint_deg(alpha, beta, offset, phase, joint) - std::stod(row[5]);
        worst = std::max(worst, std::fabs(error));
    }
    MESSAGE("worst setpoint error against the golden table: ", worst, " degrees");
    CHECK(worst < 0.0116);
}

TEST_CASE("an amplitude of 90 degrees stays within the limit at a million random phases") {
    std::mt19937 random(2005);
    double worst = 0;
    for (int k = 0; k < 1000000; ++k) {
        const uint32_t phase = static_cast<uint32_t>(random());
        const double truth = 90.0 * std::sin(2 * kPi * phase / kTurn);
        worst = std::max(worst, std::fabs(setpoint_deg(90.0, 0.0, 0.0, phase, 0) - truth));
    }
    CHECK(worst < 0.0116);
}

// The step is known to half of 1 in 5.87e10: as many frames as a day has, at 30 rad/s (412 530
// turns), are off by 3.5e-6 turn, 1.3e-3 degrees. The limit of 1 ppm would be 0.4 turns.
TEST_CASE("the phase after a day is the golden one") {
    for (const Row& row : golden("phase.csv")) {
        const uint64_t step =
            phase_step(millionths(row[0]), static_cast<uint16_t>(std::stoi(row[3])));
        const uint64_t frames = std::stoull(row[1]);
        const uint32_t phase = static_cast<uint32_t>((step * frames) >> 32);
        const int32_t error =
            static_cast<int32_t>(phase - static_cast<uint32_t>(std::stoul(row[2])));
        CAPTURE(row[0]);
        CAPTURE(frames);
        CHECK(std::fabs(error / kTurn) < 4e-6);
    }
}

TEST_CASE("the rate is right to 1e-10 from the slowest to the fastest") {
    for (int32_t omega : {1, 10000, 100000, 1234567, 5000000, 30000000, 50000000}) {
        const long double truth =
            omega * 1e-6L * 0.02L / (2 * 3.141592653589793238462643L) * 18446744073709551616.0L;
        CHECK(std::fabs(static_cast<double>(phase_step(omega) / truth - 1)) < 1e-10);
        for (const uint16_t frame_us :
             std::vector<uint16_t>{3000, 3290, 7590, 16670, 16671, 32500}) {
            const auto step = static_cast<long double>(phase_step(omega, frame_us));
            CHECK(std::fabs(static_cast<double>(step / truth * 20000 / frame_us - 1)) < 1e-10);
        }
    }
}

TEST_CASE("angles convert to nearest, both ways") {
    std::mt19937 random(3);
    std::uniform_int_distribution<int32_t> any(-114591000, 114591000);
    for (int k = 0; k < 10000; ++k) {
        const int32_t udeg = any(random);
        const double q30 = udeg * 1e-6 * kPi / 180 * 1073741824.0;
        CHECK(std::fabs(q30_from_udeg(udeg) - q30) < 1.0);  // half a unit, and 2e-10 of 2³¹
        CHECK(std::fabs(q31_turn_from_udeg(udeg) - udeg / 360e6 * 2147483648.0) < 1.0);
        const int16_t q14 = q14_from_q30(q30_from_udeg(udeg));
        CHECK(std::fabs(cdeg_from_q14(q14) - degrees(q14) * 100) <= 0.6);  // factor: 8e-6 of 11459
    }
    CHECK(q31_turn_from_udeg(180000000) == 1 << 30);
}

TEST_CASE("a lag of 180 degrees sets neighbours against each other exactly") {
    const int32_t half = q31_turn_from_udeg(180000000);
    for (uint32_t phase : {0U, 12345678U, 0x40000000U, 0xFFFFFFFFU}) {
        CHECK(gait_angle(20000, half, phase, 1) + gait_angle(20000, half, phase, 0) <= 1);
        CHECK(gait_angle(20000, half, phase, 2) == gait_angle(20000, half, phase, 0));
        CHECK(gait_angle(20000, -half, phase, 3) == gait_angle(20000, half, phase, 1));
    }
}

TEST_CASE("phase reads in thousandths of a degree and never as 360") {
    CHECK(mdeg_from_phase(0) == 0);
    CHECK(mdeg_from_phase(0x40000000U) == 90000);
    CHECK(mdeg_from_phase(0xFFFFFFFFU) == 359999);
}

TEST_CASE("a pulse is centre plus scale times angle, to nearest, either way round") {
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
