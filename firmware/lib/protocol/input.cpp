// The interrupt writes head_, mark_, arrivals_, keys_, words_, the loop tail_: single bytes, so
// that neither need shut the other out.
#include "input.h"

namespace firmware {
namespace {

uint8_t after(uint8_t place) {
    return static_cast<uint8_t>(place + 1 == Input::kSize ? 0 : place + 1);
}

}  // namespace

void Input::push(uint8_t byte) {
    const uint8_t places = free_places();
    if (places > 1) {
        store(byte);
    } else {
        if (places == 1) store(kHole);
        if (full_ < 65535) full_ = static_cast<uint16_t>(full_ + 1);
    }
    last_ = byte;
    watch(byte);
    arrivals_ = static_cast<uint8_t>(arrivals_ + 1);
}

void Input::lose() {
    if (free_places() > 1) store(kHole);
    progress_ = kOther;
}

void Input::watch(uint8_t byte) {
    static const uint8_t kWord[] = {'s', 't', 'o', 'p'};
    const uint8_t progress = forget_ ? static_cast<uint8_t>(kStart) : progress_;
    forget_ = false;
    uint8_t next = kOther;
    if (byte == '\n' || byte == '\r') {
        if (progress == kKey || progress == kStop) mark_ = head_;
        if (progress == kKey) keys_ = static_cast<uint8_t>(keys_ + 1);
        if (progress == kStop) words_ = static_cast<uint8_t>(words_ + 1);
        next = kStart;
    } else if (progress == kStart) {
        next = byte == '!' ? kKey : byte == 's' ? kS : kOther;
    } else if (progress >= kS && progress <= kSto && byte == kWord[progress - kS + 1]) {
        next = static_cast<uint8_t>(progress + 1);
    }
    progress_ = next;
}

uint8_t Input::free_places() const {
    const uint8_t head = head_, tail = tail_;
    return static_cast<uint8_t>((tail > head ? 0 : kSize) + tail - head - 1);
}

void Input::store(uint8_t byte) {
    queue_[head_] = byte;
    head_ = after(head_);
}

// Two bytes, which the interrupt may change between them.
uint16_t Input::full() const {
    uint16_t found = full_;
    while (found != full_) found = full_;
    return found;
}

int16_t Input::pop() {
    if (head_ == tail_) return -1;
    const uint8_t byte = queue_[tail_];
    tail_ = after(tail_);
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

void Input::mark_here() {
    mark_ = head_;
    forget_ = true;
}

}  // namespace firmware
