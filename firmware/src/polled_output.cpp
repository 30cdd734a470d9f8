// UCSR0A and UDR0 are the same on the ATmega328P and the ATmega2560.
#include "polled_output.h"

#include <avr/io.h>

namespace firmware {

bool PolledOutput::write(const char* text, uint8_t length) {
    if (length > room()) return false;
    while (length--) queue_[head_++] = static_cast<uint8_t>(*text++);
    return true;
}

void PolledOutput::poll() {
    if (head_ != tail_ && (UCSR0A & (1 << UDRE0))) UDR0 = queue_[tail_++];
}

}  // namespace firmware
