// The gait formula alone, for the Arduino IDE: alpha sin(omega t + (i - 1) beta) for five servos.
//
// No telemetry, no stop from a computer, no limits: keep a hand at the supply's switch, and begin
// with the robot on a box, its wheels in the air. Servos and pins are those of docs/wiring.md.
#include <Servo.h>

const int joints = 5;
const int pins[joints] = {5, 6, 7, 8, 9};  // joint 1, at the tail, first
const float alpha_deg = 40.0;              // amplitude of each joint
const float beta_deg = 75.0;               // phase from joint to joint
const float omega_rad_s = 2.0;             // rate; one wave takes 2 pi / omega seconds
const float us_per_deg = 10.0;             // of your servos: 10 for most
const int centre_us[joints] = {1500, 1500, 1500, 1500, 1500};  // pulse that holds a joint straight
const float ramp_s = 3.0;                  // time in which the amplitude grows

Servo servos[joints];
unsigned long begun_ms;

void setup() {
    for (int i = 0; i < joints; ++i) {
        servos[i].writeMicroseconds(centre_us[i]);
        servos[i].attach(pins[i]);
        delay(300);  // one after the other, so that the supply holds
    }
    begun_ms = millis();
}

void loop() {
    const float t_s = float(millis() - begun_ms) / 1000.0;
    const float amplitude_deg = alpha_deg * min(1.0, t_s / ramp_s);
    for (int i = 0; i < joints; ++i) {
        const float angle_deg = amplitude_deg * sin(omega_rad_s * t_s + i * radians(beta_deg));
        servos[i].writeMicroseconds(centre_us[i] + int(us_per_deg * angle_deg));
    }
    delay(20);  // a servo takes a new pulse every 20 ms
}
