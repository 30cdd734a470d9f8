// The controller on a simulated board: silence, stops, moves, overflow of clocks, limp servos.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "controller.h"
#include "doctest_main.h"
#include "lines.h"
#include "virtual_board.hpp"

using namespace firmware;

namespace {

// A board and the host at the other end of its wire.
struct Bench {
    VirtualBoard board;
    std::vector<std::string> lines;   // answers and events, without their CRC
    std::vector<std::string> frames;  // telemetry, without its CRC
    std::string rest;
    int number = 0;

    explicit Bench(uint64_t start_us = 0, uint32_t first_frame = 0) : board(start_us) {
        board.boot(Reset::Power, first_frame);
        run(0.1);
    }
    void run(double seconds) {
        board.run(static_cast<uint64_t>(seconds * 1e6));
        rest += board.take_output();
        for (size_t end; (end = rest.find('\n')) != std::string::npos; rest.erase(0, end + 1)) {
            const std::string line = rest.substr(0, end);
            const std::string body = line.substr(0, line.size() - 6);
            REQUIRE(line + "\n" == sealed(body));
            (body.compare(0, 2, "t:") == 0 ? frames : lines).push_back(body);
        }
    }
    // Send bytes and return the last answer or event in the following time, or "".
    std::string send(const std::string& bytes, double seconds = 0.05) {
        const size_t line_count = lines.size();
        board.send_to_board(bytes);
        run(seconds);
        return lines.size() > line_count ? lines.back() : "";
    }
    // The same for a line without a number and CRC, as a person types it.
    std::string type(const std::string& body, double seconds = 0.05) {
        return send(body + "\n", seconds);
    }
    // The same for a line with a number and CRC, as host programs send it.
    std::string ask(const std::string& body, double seconds = 0.05) {
        return send(sealed("#" + std::to_string(++number) + " " + body), seconds);
    }
    State state() const { return board.controller().state(); }
    const Counters& counters() const { return board.controller().counters(); }
    double angle_deg(uint8_t joint) const {
        return board.controller().motion().setpoints_q14()[joint] / 16384.0 * 180 /
               3.14159265358979;
    }
    bool starts(const std::string& line, const std::string& with) const {
        return line.compare(0, with.size(), with) == 0;
    }
};

}  // namespace

TEST_CASE("silence stops what moves, leaves what holds, and can be off") {
    Bench b;
    b.type("gait 30 80 5", 1.9);
    CHECK(b.state() == State::Gait);
    b.run(0.3);
    CHECK(b.state() == State::Safing);
    b.run(3);
    CHECK(b.state() == State::Safe);
    for (uint8_t i = 0; i < joint_count; ++i) CHECK(b.angle_deg(i) == 0);
    b.type("pose 20 -20 20 -20 20", 5);
    CHECK(b.state() == State::Pose);
    CHECK(std::fabs(b.angle_deg(1) + 20) < 0.01);
    b.type("set silence off");
    b.type("gait 30 80 5", 60);
    CHECK(b.state() == State::Gait);
}

TEST_CASE("only valid lines, and no noise, prevent the silence timer") {
    Bench b;
    b.ask("hello");
    b.ask("gait 30 80 5");
    for (int k = 0; k < 50; ++k) b.ask("ping", 0.1);
    CHECK(b.state() == State::Gait);
    for (int k = 0; k < 30; ++k) b.send("#9 noise *0000\n", 0.1);
    CHECK(b.state() == State::Safe);
}

TEST_CASE("a stop is obeyed whatever bytes and pauses come before and after it") {
    const std::string prefixes[] = {"",
                                    "x",
                                    "#9 pin",
                                    "#12 gait 3",
                                    "\xFF",
                                    std::string("\x00\xFE\x80", 3),
                                    "sto",
                                    "#9 ping *",
                                    "an overlong line with no end in sight, an overlong line with "
                                    "no end in sight, an overlong"};
    const std::string suffixes[] = {"", "\n", "\xFF", "x\n", " *1234\n"};
    for (const std::string& prefix : prefixes) {
        for (const std::string& suffix : suffixes) {
            for (const double pause_s : {0.0, 0.15}) {
                for (const bool session : {false, true}) {
                    CAPTURE(prefix);
                    CAPTURE(suffix);
                    CAPTURE(pause_s);
                    CAPTURE(session);
                    Bench b;
                    if (session) b.ask("hello");
                    session ? b.ask("gait 30 80 5", 0.2) : b.type("gait 30 80 5", 0.2);
                    b.send(prefix, pause_s);
                    const size_t first_line = b.lines.size();
                    b.send("!" + suffix, 0.024);
                    CHECK(b.state() == State::Hold);
                    REQUIRE(b.lines.size() >= first_line + 2);
                    CHECK(b.lines[first_line] == "state: hold why=key");
                    CHECK(b.lines[first_line + 1] == "ok: #!");
                    const double hold_deg = b.angle_deg(2);
                    b.run(0.3);
                    CHECK(b.angle_deg(2) == hold_deg);
                    CHECK(b.state() == State::Hold);
                }
            }
        }
    }
}

TEST_CASE("a new centre is approached slowly") {
    Bench b;
    b.type("pose straight", 1);
    for (const int centre : {1590, 1440}) {
        int previous_us = b.board.servo_us(3);
        b.type("trim 4 centre " + std::to_string(centre), 0.02);
        for (int k = 0; k < 100; ++k) {
            CHECK(std::abs(b.board.servo_us(3) - previous_us) <= 8);
            previous_us = b.board.servo_us(3);
            b.run(0.02);
        }
        CHECK(previous_us == centre);
    }
}

TEST_CASE("frames go on evenly when the clock and the frame number overflow") {
    Bench b((1ULL << 32) - 2000000, 0xFFFFFFFFu - 100);
    b.type("set silence off");
    b.type("gait 30 80 5", 1);
    b.frames.clear();
    b.run(3);
    uint32_t last_number = static_cast<uint32_t>(std::stoul(b.frames.at(0).substr(2)));
    for (size_t k = 1; k < b.frames.size(); ++k) {
        const uint32_t number = static_cast<uint32_t>(std::stoul(b.frames[k].substr(2)));
        CHECK(number == static_cast<uint32_t>(last_number + 1));
        last_number = number;
    }
    CHECK(last_number < 200);
    CHECK(b.counters().overruns == 0);
    CHECK(b.counters().late_us < 100);
}

TEST_CASE("missed frames are counted and the phase follows the clock") {
    Bench b, steady;
    for (Bench* bench : {&b, &steady}) {
        bench->type("set silence off");
        bench->type("gait 30 80 5", 2);
    }
    b.board.stall(205000);
    steady.run(0.205);
    b.run(1);
    steady.run(1);
    CHECK(b.counters().overruns >= 9);  // 10.25 frames, minus the rest of the running frame
    CHECK(b.counters().overruns <= 10);
    CHECK(b.board.controller().frame_number() == steady.board.controller().frame_number());
    CHECK(b.board.controller().motion().phase() == steady.board.controller().motion().phase());
}

TEST_CASE("joints that a slow servo limits are counted, upwards and downwards") {
    Bench b;
    b.type("set silence off");
    b.type("gait 60 0 3", 8);
    CHECK(b.type("set servo_speed 100") == "ok: #-");
    int limited_frames[2] = {};  // numbers of frames with all joints limited: downwards, upwards
    double previous_deg = b.angle_deg(0);
    for (int frame = 0; frame < 210; ++frame) {  // two periods
        b.run(0.02);
        const int clipped = b.board.controller().motion().clipped();
        limited_frames[b.angle_deg(0) > previous_deg] += clipped == joint_count;
        previous_deg = b.angle_deg(0);
    }
    CHECK(limited_frames[0] > 20);
    CHECK(limited_frames[1] > 20);
}

TEST_CASE("an idle robot is limp; its servos return to their setpoints one after another") {
    Bench b;
    b.type("pose 20 -20 20 -20 20", 4);
    CHECK(b.board.attached() == joint_count);
    CHECK(b.type("idle") == "ok: #-");
    CHECK(b.board.attached() == 0);
    b.run(1);
    b.type("pose straight", 0.02);
    for (uint8_t joint = 0; joint < joint_count; ++joint) {
        CHECK(b.board.attached() == joint + 1);
        CHECK(b.board.servo_us(joint) == (joint % 2 == 0 ? 1700 : 1300));
        CHECK(b.angle_deg(0) == doctest::Approx(20).epsilon(1e-3));  // nothing moves meanwhile
        b.run(0.1);
    }
    b.run(3);
    CHECK(b.board.servo_us(0) == 1500);
}

TEST_CASE("a stop ends the attaching of servos; limp ones stay limp until the next move") {
    Bench b;
    b.type("gait 30 80 5", 0.15);
    CHECK(b.board.attached() == 2);
    b.type("!");
    b.run(3);
    CHECK(b.board.attached() == 2);
    CHECK(b.frames.back().find(" p=1500,1500,0,0,0 ") != std::string::npos);
    b.type("pose straight", 1);
    CHECK(b.board.attached() == joint_count);
}

TEST_CASE("a robot at rest goes limp some time after its host's last line") {
    for (const char* last_command : {"pose straight 10", "gait 30 80 5", "stop"}) {
        CAPTURE(last_command);
        Bench b;
        b.type("set limp 5");
        b.type("gait 30 80 5", 1);
        for (int k = 0; k < 12; ++k) b.type("ping", 1);  // keeps the limp timer from starting
        CHECK(b.state() == State::Gait);
        b.type(last_command, 4.9);
        const bool stopped = last_command[0] == 's', posed = last_command[0] == 'p';
        CHECK(b.state() == (stopped ? State::Hold : posed ? State::Pose : State::Safe));
        b.run(0.3);
        CHECK(b.state() == State::Idle);
        CHECK(b.lines.back() == "state: idle why=limp");
        CHECK(b.board.attached() == 0);
    }
}

TEST_CASE("silence while servos are being attached makes the attached ones limp") {
    Bench b;
    b.type("set silence 0.2");
    b.type("pose straight", 0.15);
    CHECK(b.board.attached() == 2);
    b.run(0.1);
    CHECK(b.state() == State::Idle);
    CHECK(b.lines.back() == "state: idle why=silence");
    CHECK(b.board.attached() == 0);
    b.type("pose straight", 0.15);
    b.board.send_to_board("status\n");
    b.run(0.03);
    bool is_reported = false;
    for (const std::string& line : b.lines) is_reported |= line.find(" attached=2 ") < line.size();
    CHECK(is_reported);
}

TEST_CASE("a stop overtakes commands from before it, and these are not obeyed after it") {
    Bench b;
    b.ask("hello");
    b.ask("gait 30 80 5", 2);
    b.lines.clear();
    std::string lines;
    for (const char* body : {"help", "set", "gait 45 80 5"}) {
        lines += sealed("#" + std::to_string(++b.number) + " " + body);
    }
    b.board.send_to_board(lines + "!\n");
    b.run(0.004);  // time to receive these bytes, and at most a frame
    CHECK(b.state() == State::Hold);
    b.run(1);
    CHECK(b.state() == State::Hold);
    size_t stopped = 0, verdicts = 0;
    for (const std::string& line : b.lines) {
        if (b.starts(line, "err: #") && line.find(" stopped - ") != std::string::npos) ++stopped;
        if (b.starts(line, "err: ") || b.starts(line, "ok: ")) ++verdicts;
    }
    CHECK(stopped >= 1);
    CHECK(verdicts == 4);
    CHECK(b.ask("gait 45 80 5") == "ok: #6");
    CHECK(b.state() == State::Gait);
}

TEST_CASE("a change between allowed gaits never clips, and accelerations stay bounded") {
    struct Shape {
        double alpha, beta, omega, offset;
    };
    const Shape shapes[] = {{50, -80, 9.9, 0}, {50, 80, 9.9, 0},   {20, 60, 25, 0},
                            {50, 60, 10, 0},   {10, 180, 30, -20}, {89, 0, 5.6, 0},
                            {30, 80, 1, 40},   {30, 80, 5, -40},   {5, 120, 2, 0}};
    const int n = sizeof shapes / sizeof shapes[0];
    // Contains each ordered pair of gaits once: 0 0 1 0 2 ... 1 1 2 1 3 ... 0.
    std::vector<int> tour;
    for (int i = 0; i < n; ++i) {
        tour.push_back(i);
        for (int j = i + 1; j < n; ++j) tour.insert(tour.end(), {i, j});
    }
    tour.push_back(0);
    const auto max_acceleration = [&](int k) {
        return shapes[k].alpha * shapes[k].omega * shapes[k].omega;
    };
    Bench b;
    b.type("set silence off");
    double previous_deg[kMaxJoints] = {}, second_last_deg[kMaxJoints] = {};
    int last = 0;
    for (const int next : tour) {
        const Shape& s = shapes[next];
        b.type("gait " + std::to_string(s.alpha) + " " + std::to_string(s.beta) + " " +
                   std::to_string(s.omega) + " " + std::to_string(s.offset),
               0.02);
        double worst = 0;
        for (int frame = 0; frame < 700; ++frame) {
            b.run(0.02);
            for (uint8_t i = 0; i < joint_count; ++i) {
                const double angle_deg = b.angle_deg(i);
                const double acceleration =
                    (angle_deg - 2 * previous_deg[i] + second_last_deg[i]) / (0.02 * 0.02);
                if (frame > 1) worst = std::max(worst, std::fabs(acceleration));
                second_last_deg[i] = previous_deg[i];
                previous_deg[i] = angle_deg;
            }
        }
        CAPTURE(last);
        CAPTURE(next);
        CHECK(b.counters().clipped == 0);
        // The second difference of setpoints, each rounded to 0.0035 degrees and in a blend of two
        // gaits rounded twice, is wrong by up to 35 deg/s².
        CHECK(worst <= 2 * std::max(max_acceleration(last), max_acceleration(next)) + 35);
        last = next;
    }
}
