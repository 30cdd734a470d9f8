// The interrupt writes head_, mark_, keys_, words_, the loop tail_: single bytes, so that neither
// need shut the other out. A fence keeps the bytes of the queue on their side of head_ and tail_.
#include "input.h"

namespace firmware {
namespace {

uint8_t next_place(uint8_t place) {
    return static_cast<uint8_t>(place + 1 == input_size(joint_count) ? 0 : place + 1);
}

// For the compiler alone: interrupt and loop share one processor.
void fence() { __atomic_signal_fence(__ATOMIC_SEQ_CST); }

}  // namespace

void Input::push(uint8_t byte) {
    if (byte != '!') {
        const uint8_t places = free_places();
        if (places > 0) store(places > 1 ? byte : kHole);
        if (places <= 1 && overflow_count_ < 65535)
            overflow_count_ = static_cast<uint16_t>(overflow_count_ + 1);
    }
    watch(byte);
}

void Input::lose() {
    if (free_places() > 1) store(kHole);
    progress_ = 0;
}

void Input::watch(uint8_t byte) {
    static const uint8_t kWord[] = {'s', 't', 'o', 'p'};
    const uint8_t progress = progress_;
    const bool word = progress == sizeof kWord && (byte == '\n' || byte == '\r');
    if (word || byte == '!') mark_ = head_;
    if (byte == '!') keys_ = static_cast<uint8_t>(keys_ + 1);
    if (word) words_ = static_cast<uint8_t>(words_ + 1);
    const bool next = progress < sizeof kWord && byte == kWord[progress];
    progress_ = next ? static_cast<uint8_t>(progress + 1) : byte == kWord[0];
}

uint8_t Input::free_places() const {
    const uint8_t head = head_, tail = tail_;
    return static_cast<uint8_t>((tail > head ? 0 : input_size(joint_count)) + tail - head - 1);
}

void Input::store(uint8_t byte) {
    queue_[head_] = byte;
    fence();
    head_ = next_place(head_);
}

// Two bytes, which the interrupt may change between them.
uint16_t Input::overflow_count() const {
    uint16_t count = overflow_count_;
    while (count != overflow_count_) count = overflow_count_;
    return count;
}

// The order of the looks matters: a stop that comes between two of them stands behind `head`, and
// is met by the next call.
int16_t Input::pop() {
    const uint8_t head = head_, stopped = stops();
    if (stopped != stops_seen_ && tail_ == mark_) {
        stops_seen_ = stopped;
        return kStopHere;
    }
    if (head == tail_) return kNothing;
    fence();
    const uint8_t byte = queue_[tail_];
    fence();
    tail_ = next_place(tail_);
    return byte;
}

char Input::take_stop() {
    if (keys_taken_ != keys_) {
        ++keys_taken_;
        return '!';
    }
    if (words_taken_ != words_) {
        ++words_taken_;
        return 's';
    }
    return 0;
}

}  // namespace firmware
