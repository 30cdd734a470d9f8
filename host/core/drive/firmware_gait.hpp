// The setpoints of a settled gait as the firmware's own fixed-point code gives them.
#pragma once

#include <cmath>
#include <cstdint>

#include "gait.h"  // firmware/lib/gait
#include "model/params.hpp"

namespace serpenoid {

class FirmwareGait {
  public:
    // The ranges of the firmware (|alpha|, |offset| <= 90 deg, |beta| <= 180 deg, omega <= 50
    // rad/s) are the caller's to check.
    explicit FirmwareGait(const Gait& g, double frame_s = firmware::kFrameUs * 1e-6)
        : alpha_(firmware::q14_from_q30(firmware::q30_from_udeg(udeg(g.alpha)))),
          offset_(firmware::q14_from_q30(firmware::q30_from_udeg(udeg(g.offset)))),
          beta_(firmware::q31_turn_from_udeg(udeg(g.beta))),
          step_(
              of_frame(firmware::phase_step(static_cast<std::int32_t>(std::llround(g.omega * 1e6))),
                       frame_s)) {}

    // Joint angles of one frame, radians.
    void setpoints(std::uint64_t frame, double* angle_rad, std::size_t joints) const {
        const auto phase = static_cast<std::uint32_t>((step_ * frame) >> 32);
        for (std::size_t i = 0; i < joints; ++i)
            angle_rad[i] = (offset_ + firmware::gait_angle(alpha_, beta_, phase,
                                                           static_cast<std::uint8_t>(i))) /
                           16384.0;
    }

  private:
    // The firmware's own step, unless frames have another length than its own.
    static std::uint64_t of_frame(std::uint64_t step, double frame_s) {
        const double part = frame_s / (firmware::kFrameUs * 1e-6);
        return part == 1 ? step : static_cast<std::uint64_t>(static_cast<double>(step) * part);
    }
    static std::int32_t udeg(double angle_rad) {
        return static_cast<std::int32_t>(std::llround(angle_rad * 180e6 / 3.14159265358979323846));
    }
    std::int16_t alpha_, offset_;
    std::int32_t beta_;
    std::uint64_t step_;
};

}  // namespace serpenoid
