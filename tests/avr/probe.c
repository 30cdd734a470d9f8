// A program for checking the simulated board itself: obeys single letters over the serial port.
#include <avr/eeprom.h>
#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/wdt.h>
#include <util/delay.h>

static uint8_t boots __attribute__((section(".noinit")));

static void say(uint8_t byte) {
    while (!(UCSR0A & 1 << UDRE0)) {
    }
    UDR0 = byte;
}

static void obey(uint8_t letter) {
    if (letter == 'd') _delay_ms(5);  // deaf: what arrives meanwhile overruns the receiver
    if (letter == 'p') {
        PORTB |= 1;
        _delay_us(1500);
        PORTB &= (uint8_t)~1;
    }
    if (letter == 'e')
        for (uint8_t i = 0; i < 8; i++) eeprom_write_byte((uint8_t*)(uintptr_t)i, i);
    if (letter == 'b')
        for (uint8_t i = 0; i < 8; i++) say((uint8_t)('0' + i));
    if (letter == 'w') wdt_enable(WDTO_60MS);
    say(letter);
}

int main(void) {
    const uint8_t cause = MCUSR;
    MCUSR = 0;
    wdt_disable();
    boots = cause & 1 << PORF ? 1 : (uint8_t)(boots + 1);
    DDRB = 1;
    UCSR0A = 1 << U2X0;
    UBRR0 = 7;  // 250000 baud
    UCSR0B = 1 << RXEN0 | 1 << TXEN0;
    sei();
    say('B');
    say((uint8_t)('0' + boots));
    say((uint8_t)('0' + cause));
    say('\n');
    for (;;)
        if (UCSR0A & 1 << RXC0) obey(UDR0);
}
