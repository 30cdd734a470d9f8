// The controller on a Cortex-M, in an emulator: `Hardware` in one file, as any port has it. It
// plays the file `script`, and writes what the board says to the file `said`.
//
// Clock, wire and EEPROM keep the same time as the virtual board's (firmware/virtual), so that both
// must say the same, byte for byte.
#include <stdio.h>
#include <string.h>

#include "controller.h"

using namespace firmware;

namespace {

const uint32_t kByteUs = 40, kEepromWriteUs = 3400;

struct Wire {
    uint8_t bytes[4096];
    unsigned head, tail;
};

class Cortex : public Hardware {
  public:
    Cortex() : serial_(), now_us_(0), busy_until_us_(0), to_board_() {
        memset(eeprom_, 0xFF, sizeof eeprom_);
    }

    void put(uint8_t byte) { to_board_.bytes[to_board_.head++ % sizeof to_board_.bytes] = byte; }

    // One byte each way, and one look at the controller.
    void step(Controller& controller, FILE* said) {
        now_us_ += kByteUs;
        if (to_board_.tail != to_board_.head) {
            serial_.in.push(to_board_.bytes[to_board_.tail++ % sizeof to_board_.bytes]);
        }
        if (!serial_.out.empty()) fputc(serial_.out.take(), said);
        controller.poll();
    }

    uint32_t micros() override { return now_us_; }
    SerialQueues& serial() override { return serial_; }
    void attach(uint8_t, int16_t) override {}
    void detach() override {}
    void pulses(const int16_t (&)[kMaxJoints], uint32_t) override {}
    uint16_t least_frame_us() const override {
        return joint_count <= 7 ? 3000 : 2500 * (joint_count + 1);
    }
    void begin_frames(uint16_t, uint16_t) override {}
    uint16_t unused_ram() override { return 0; }

    uint8_t read(uint16_t address) override { return eeprom_[address]; }
    bool ready() override { return static_cast<int32_t>(now_us_ - busy_until_us_) >= 0; }
    void write(uint16_t address, uint8_t byte) override {
        eeprom_[address] = byte;
        busy_until_us_ = now_us_ + kEepromWriteUs;
    }

  private:
    SerialQueues serial_;
    uint32_t now_us_, busy_until_us_;
    Wire to_board_;
    uint8_t eeprom_[1024];
};

Cortex hardware;
Controller controller(hardware);

}  // namespace

// `>`, a count and a space: so many bytes for the board; `~`, a count and a space: so many steps of
// 40 us; `<`: the other board was read here.
int main() {
    FILE* const script = fopen("script", "rb");
    FILE* const said = fopen("said", "wb");
    if (!script || !said) return 1;
    controller.begin(Start{"virtual", Reset::Power, 0});
    for (int mark; (mark = fgetc(script)) != EOF;) {
        unsigned long count = 0;
        if (mark != '<' && (fscanf(script, "%lu", &count) != 1 || fgetc(script) != ' ')) return 1;
        if (mark == '<') fputc(0, said);
        for (; mark == '>' && count != 0; --count) {
            hardware.put(static_cast<uint8_t>(fgetc(script)));
        }
        for (; mark == '~' && count != 0; --count) hardware.step(controller, said);
    }
    return fclose(said);
}

// What a bare program of C++ needs: where it begins, and what calls of pure functions end in.
extern "C" {
void _start();
extern char __stack[];
void __cxa_pure_virtual() {
    for (;;) {
    }
}
__attribute__((section(".vectors"), used)) void* const vectors[] = {
    __stack, reinterpret_cast<void*>(_start)};
}
