// The board's programme: a table of contents.
#include <Arduino.h>
#include <Servo.h>

#include "board.h"
#include "motion.h"
#include "polled_output.h"
#include "pulse.h"
#include "telemetry.h"

namespace {

const char kGaitState[] PROGMEM = "gait";
const firmware::Trim kTrim = {1500, 573 * 32, 1, -25736, 25736};

Servo servos[firmware::kJoints];
firmware::Motion motion;
firmware::Frame frame;
firmware::PolledOutput output;
uint32_t due_us;

void start_gait() {
    firmware::MotionLimits limits = {};
    limits.angle_step_q30 = firmware::q30_from_udeg(60000000 / 50);
    limits.beta_step_q31_turn = firmware::q31_turn_from_udeg(60000000 / 50);
    limits.rate_step = firmware::phase_step(5000000 / 50);
    limits.pose_step_q30 = firmware::q30_from_udeg(45000000 / 50);
    limits.servo_step_q14 = firmware::q14_from_q30(firmware::q30_from_udeg(500000000 / 50));
    for (uint8_t i = 0; i < firmware::kJoints; ++i) {
        limits.low_q14[i] = kTrim.low_q14;
        limits.high_q14[i] = kTrim.high_q14;
    }
    motion.limit(limits);
    motion.gait(firmware::Gait{30000000, 80000000, 5000000, 0});
}

void move_servos() {
    for (uint8_t i = 0; i < firmware::kJoints; ++i) {
        frame.setpoint_q14[i] = motion.setpoints_q14()[i];
        frame.pulse_us[i] = firmware::pulse_us(kTrim, frame.setpoint_q14[i]);
        servos[i].writeMicroseconds(frame.pulse_us[i] - board::kPulseExcessUs);
    }
    frame.phase = motion.phase();
}

void report() {
    static firmware::Text line;
    line.clear();
    firmware::write_telemetry(line, frame);
    output.write(line.data(), line.length());
}

}  // namespace

void setup() {
    Serial.begin(board::kBaud);
    Serial.write('\n');  // ends whatever a boot loader has left on the line
    for (uint8_t i = 0; i < firmware::kJoints; ++i) servos[i].attach(board::kServoPins[i]);
    frame.state = kGaitState;
    start_gait();
    due_us = micros();
}

void loop() {
    output.poll();
    const uint32_t now_us = micros();
    if (static_cast<int32_t>(now_us - due_us) < 0) return;
    frame.start_us = now_us;
    frame.late_us = now_us - due_us;
    due_us += firmware::kFrameUs;
    motion.advance(1);
    move_servos();
    frame.run_us = micros() - now_us;
    report();
    ++frame.number;
}
