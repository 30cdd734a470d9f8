// UCSR0A, UDR0 and UBRR0 are the same on the ATmega328P and the ATmega2560, but for one name.
#include "serial_port.h"

#include <Arduino.h>
#include <avr/interrupt.h>
#include <avr/io.h>

#include "board.h"

#ifdef USART_RX_vect
#define RECEIVED_vect USART_RX_vect
#else
#define RECEIVED_vect USART0_RX_vect
#endif

namespace serial_port {

firmware::SerialQueues queues;

void begin() {
    UCSR0A = _BV(U2X0);
    UBRR0 = F_CPU / 8 / board::kBaud - 1;
    UCSR0C = _BV(UCSZ01) | _BV(UCSZ00);
    UCSR0B = _BV(RXEN0) | _BV(TXEN0) | _BV(RXCIE0);
    UDR0 = '\n';  // ends whatever a boot loader has left on the line
}

void poll() {
    if (!queues.output.empty() && (UCSR0A & _BV(UDRE0))) UDR0 = queues.output.take();
}

}  // namespace serial_port

// The flags belong to the byte that is read next. A byte without its stop bit is noise, but for a
// stop.
ISR(RECEIVED_vect) {
    const uint8_t flags = UCSR0A;
    const uint8_t byte = UDR0;
    UCSR0B &= static_cast<uint8_t>(~_BV(RXCIE0));
    sei();  // a servo's edge need not wait for the rest, the next byte must
    if (flags & _BV(DOR0)) serial_port::queues.input.lose();
    const bool noise = (flags & _BV(FE0)) && byte != '!';
    serial_port::queues.input.push(noise ? firmware::Input::kHole : byte);
    cli();
    UCSR0B |= _BV(RXCIE0);
}
