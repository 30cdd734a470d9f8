// The two-wire unit by its data sheet (ATmega328P, section 22), as master, at the pace that TWBR
// sets; one PCA9685 is on the bus.
//
// It takes the place of simavr's own unit, whose flag TWINT stays set when a program clears it (it
// is marked `raise_sticky`), so that a program that polls believes every step done at once; it also
// knows no bus time and no bus that is held.
#include "inside.h"

enum { BIT_RATE, STATUS, OWN_ADDRESS, DATA, CONTROL };  // registers from TWBR on
enum { TWINT = 0x80, TWEA = 0x40, TWSTA = 0x20, TWSTO = 0x10, TWEN = 0x04 };
enum { NO_STATE = 0xf8, STARTED = 0x08, STARTED_AGAIN = 0x10, LOST = 0x38 };
enum { FIRST_REGISTER = 0xb8 };

static uint8_t* registers(struct board* b) { return b->avr->data + FIRST_REGISTER; }

static uint64_t bit_cycles(struct board* b) {
    const uint8_t* r = registers(b);
    return 16 + 2 * (uint64_t)r[BIT_RATE] * (1u << 2 * (r[STATUS] & 3));
}

static void set_status(struct board* b, uint8_t status) {
    b->twi.status = status;
    registers(b)[STATUS] = (uint8_t)(status | (registers(b)[STATUS] & 3));
}

static void finish(struct board* b, uint8_t status) {
    b->twi.doing = TWI_NOTHING;
    set_status(b, status);
    registers(b)[CONTROL] |= TWINT;
}

static void start(struct board* b) {
    finish(b, b->twi.owned ? STARTED_AGAIN : STARTED);
    b->twi.owned = b->twi.addressing = 1;
    pca9685_begin(&b->pca9685);
}

static void send(struct board* b) {
    const uint8_t byte = b->twi.byte;
    const int first = b->twi.addressing, ack = pca9685_take(&b->pca9685, byte, first);
    if (first) b->twi.reading = byte & 1;
    b->twi.addressing = 0;
    if (!first) return finish(b, ack ? 0x28 : 0x30);
    if (b->twi.reading) return finish(b, ack ? 0x40 : 0x48);
    finish(b, ack ? 0x18 : 0x20);
}

static void receive(struct board* b) {
    registers(b)[DATA] = pca9685_give(&b->pca9685);
    finish(b, registers(b)[CONTROL] & TWEA ? 0x50 : 0x58);
}

static void stop(struct board* b) {
    pca9685_end(&b->pca9685);
    b->twi.doing = TWI_NOTHING;
    b->twi.owned = 0;
    registers(b)[CONTROL] &= (uint8_t)~TWSTO;
    set_status(b, NO_STATE);
}

// A clock that is held stretches every step; data that are held let none begin or end, and a byte
// under way is lost to another master.
static avr_cycle_count_t step_done(avr_t* avr, avr_cycle_count_t when, void* param) {
    (void)avr;
    struct board* b = param;
    const int held = pca9685_holds_data(&b->pca9685);
    const int on_byte = b->twi.doing == TWI_SENDS || b->twi.doing == TWI_RECEIVES;
    if (b->pca9685.fault == PCA9685_CLOCK_LOW || (held && !on_byte)) {
        return when + b->twi.bit_cycles;
    }
    if (held) {
        b->twi.owned = 0;
        finish(b, LOST);
    } else if (b->twi.doing == TWI_STARTS) {
        start(b);
    } else if (b->twi.doing == TWI_SENDS) {
        send(b);
    } else if (b->twi.doing == TWI_RECEIVES) {
        receive(b);
    } else {
        stop(b);
    }
    return 0;
}

static void begin(struct board* b, enum twi_step what, unsigned bits) {
    b->twi.doing = what;
    b->twi.byte = registers(b)[DATA];
    b->twi.begun_cycle = b->avr->cycle;
    b->twi.bit_cycles = bit_cycles(b);
    avr_cycle_timer_register(b->avr, bits * b->twi.bit_cycles, step_done, b);
}

static void switch_off(struct board* b) {
    avr_cycle_timer_cancel(b->avr, step_done, b);
    b->twi.doing = TWI_NOTHING;
    b->twi.owned = 0;
    set_status(b, NO_STATE);
}

static void write_control(avr_t* avr, avr_io_addr_t addr, uint8_t v, void* param) {
    struct board* b = param;
    const uint8_t waits = avr->data[addr] & TWINT;
    avr->data[addr] = v & (uint8_t)~TWINT;
    if (!(v & TWEN)) return switch_off(b);
    if (waits && !(v & TWINT)) {
        avr->data[addr] |= TWINT;
    } else if (b->twi.doing != TWI_NOTHING) {
        b->counts.twi_misused++;
    } else if (v & TWSTO) {
        begin(b, TWI_STOPS, 1);
    } else if (v & TWSTA) {
        begin(b, TWI_STARTS, 1);
    } else if (b->twi.owned) {
        begin(b, b->twi.reading && !b->twi.addressing ? TWI_RECEIVES : TWI_SENDS, 9);
    }
}

static void write_status(avr_t* avr, avr_io_addr_t addr, uint8_t v, void* param) {
    (void)param;
    avr->data[addr] = (uint8_t)((avr->data[addr] & 0xf8) | (v & 3));
}

static void write_data(avr_t* avr, avr_io_addr_t addr, uint8_t v, void* param) {
    struct board* b = param;
    if (b->twi.doing != TWI_NOTHING) b->counts.twi_misused++;
    avr->data[addr] = v;
}

static uint8_t read_data(avr_t* avr, avr_io_addr_t addr, void* param) {
    (void)param;
    return avr->data[addr];
}

// What the chip was saying when the master fell silent stands on the wire until it is clocked out.
void twi_after_reset(struct board* b) {
    uint64_t bits_left = 0;
    if (b->twi.doing == TWI_RECEIVES) {
        const uint64_t bits = (b->avr->cycle - b->twi.begun_cycle) / b->twi.bit_cycles;
        bits_left = bits > 8 ? 1 : 9 - bits;
    }
    pca9685_cut_short(&b->pca9685, (uint8_t)bits_left);
    switch_off(b);
}

void twi_attach(struct board* b) {
    const avr_io_addr_t at[] = {FIRST_REGISTER + CONTROL, FIRST_REGISTER + STATUS,
                                FIRST_REGISTER + DATA};
    const avr_io_write_t writers[] = {write_control, write_status, write_data};
    for (int i = 0; i < 3; i++) {
        b->avr->io[AVR_DATA_TO_IO(at[i])].w.c = writers[i];
        b->avr->io[AVR_DATA_TO_IO(at[i])].w.param = b;
    }
    b->avr->io[AVR_DATA_TO_IO(at[2])].r.c = read_data;
    b->avr->io[AVR_DATA_TO_IO(at[2])].r.param = b;
    switch_off(b);
}
