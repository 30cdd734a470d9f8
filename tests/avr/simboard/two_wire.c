// The two-wire unit by its data sheet (ATmega328P, section 22), as master, at the pace that TWBR
// sets, and a PCA9685 on its bus: registers that count up, outputs that change at the stop, a rate
// that is set asleep. The chip may have no power, or hold the data wire.
//
// It takes the place of simavr's own unit, whose flag TWINT stays set when a program clears it (it
// is marked `raise_sticky`), so that a program that polls believes every step done at once.
#include <string.h>

#include "inside.h"

enum { BIT_RATE, STATUS, OWN_ADDRESS, DATA, CONTROL, FIRST_REGISTER = 0xb8 };  // from TWBR on
enum { TWINT = 0x80, TWSTA = 0x20, TWSTO = 0x10, TWEN = 0x04, NO_STATE = 0xf8 };
enum { NOBODYS, ADDRESSING, CALLING, POINTING, WRITING, READING };  // stages of a job
enum { ADDRESS = 0x80, GENERAL_CALL = 0x00, SOFTWARE_RESET = 0x06 };
enum { MODE1 = 0x00, FIRST = 0x06, LAST = 0x45, ALL = 0xfa, LAST_ALL = 0xfd, PRESCALE = 0xfe };
enum { COUNTS_UP = 0x20, SLEEP = 0x10, FULL_OFF = 0x10 };

static uint8_t* unit(struct board* b) { return b->avr->data + FIRST_REGISTER; }

static void power_up(struct two_wire* w) {
    memset(w->chip, 0, sizeof w->chip);
    w->chip[MODE1] = 0x11;
    for (int r = FIRST + 3; r <= LAST; r += 4) w->chip[r] = FULL_OFF;
    w->chip[PRESCALE] = 0x1e;
    memcpy(w->outputs, w->chip + FIRST, sizeof w->outputs);
}

static void write_register(struct two_wire* w, uint8_t v) {
    const uint8_t r = w->next;
    if (r >= ALL && r <= LAST_ALL) {
        for (int c = FIRST + r - ALL; c <= LAST; c += 4) w->chip[c] = v;
    } else if (r != PRESCALE || w->chip[MODE1] & SLEEP) {
        w->chip[r] = v;
    }
    w->changed |= r >= FIRST && r <= LAST_ALL;
    if (w->chip[MODE1] & COUNTS_UP) w->next++;
}

// Take a byte from the master; return whether the chip acknowledges.
static int take(struct two_wire* w, uint8_t byte) {
    if (w->fault == PCA9685_SILENT) return 0;
    if (w->stage == CALLING && byte == SOFTWARE_RESET) power_up(w);
    if (w->stage == WRITING) write_register(w, byte);
    if (w->stage == POINTING) {
        w->next = byte;
        w->stage = WRITING;
    }
    return 1;
}

static uint8_t address(struct two_wire* w, uint8_t byte) {
    const int reads = byte & 1, well = w->fault != PCA9685_SILENT;
    w->stage = byte == GENERAL_CALL ? CALLING : reads ? READING : POINTING;
    const int ack = well && (byte == GENERAL_CALL || (byte & 0xfe) == ADDRESS);
    return (uint8_t)((reads ? 0x40 : 0x18) + (ack ? 0 : 8));
}

static avr_cycle_count_t step_done(avr_t* avr, avr_cycle_count_t when, void* param) {
    (void)avr;
    struct board* b = param;
    struct two_wire* w = &b->two_wire;
    uint8_t* u = unit(b);
    uint8_t status = NO_STATE;
    if (w->fault == PCA9685_DATA_LOW) return when + w->bit_cycles;  // nothing begins or ends
    w->busy = 0;
    if (w->control & TWSTO) {  // outputs change at the stop, all at once
        w->bursts += w->changed;
        if (w->changed) memcpy(w->outputs, w->chip + FIRST, sizeof w->outputs);
        w->stage = NOBODYS;
        w->changed = 0;
        u[CONTROL] &= (uint8_t)~TWSTO;
    } else if (w->control & TWSTA) {
        status = w->stage == NOBODYS ? 0x08 : 0x10;
        w->stage = ADDRESSING;
    } else if (w->stage == ADDRESSING) {
        status = address(w, u[DATA]);
    } else if (w->stage == READING) {
        u[DATA] = w->fault == PCA9685_SILENT ? 0xff : w->chip[w->next];
        status = 0x58;
    } else {
        status = take(w, u[DATA]) ? 0x28 : 0x30;
    }
    if (!(w->control & TWSTO)) u[CONTROL] |= TWINT;
    u[STATUS] = status;
    return 0;
}

static void write_control(avr_t* avr, avr_io_addr_t addr, uint8_t v, void* param) {
    struct board* b = param;
    struct two_wire* w = &b->two_wire;
    avr->data[addr] = v & (uint8_t)~TWINT;
    if (!(v & TWEN)) return two_wire_after_reset(b);
    b->counts.twi_misused += w->busy;
    w->busy = 1;
    w->control = v;
    w->bit_cycles = 16 + 2u * unit(b)[BIT_RATE];
    const unsigned bits = v & (TWSTO | TWSTA) ? 1 : 9;
    avr_cycle_timer_register(avr, bits * w->bit_cycles, step_done, b);
}

static void write_data(avr_t* avr, avr_io_addr_t addr, uint8_t v, void* param) {
    struct board* b = param;
    b->counts.twi_misused += b->two_wire.busy;
    avr->data[addr] = v;
}

void two_wire_after_reset(struct board* b) {
    avr_cycle_timer_cancel(b->avr, step_done, b);
    b->two_wire.stage = NOBODYS;
    b->two_wire.busy = 0;
    unit(b)[STATUS] = NO_STATE;
}

static uint8_t read_data(avr_t* avr, avr_io_addr_t addr, void* param) {
    (void)param;
    return avr->data[addr];
}

// Take the place of simavr's own unit.
static void handle(struct board* b, int at, avr_io_write_t writes, avr_io_read_t reads) {
    const avr_io_addr_t io = (avr_io_addr_t)AVR_DATA_TO_IO(FIRST_REGISTER + at);
    b->avr->io[io].w.c = writes;
    b->avr->io[io].r.c = reads;
    b->avr->io[io].w.param = b->avr->io[io].r.param = b;
}

void two_wire_attach(struct board* b) {
    handle(b, CONTROL, write_control, NULL);
    handle(b, DATA, write_data, read_data);
    two_wire_after_reset(b);
}

void board_add_pca9685(struct board* b, char port, int data_bit) {
    b->two_wire.data_wire =
        avr_io_getirq(b->avr, AVR_IOCTL_IOPORT_GETIRQ((uint32_t)port), data_bit);
    board_fault_pca9685(b, PCA9685_SILENT);
    board_fault_pca9685(b, PCA9685_WELL);
}

void board_fault_pca9685(struct board* b, enum pca9685_fault fault) {
    struct two_wire* w = &b->two_wire;
    if (fault == PCA9685_SILENT) power_up(w);
    w->fault = fault;
    avr_raise_irq(w->data_wire, fault != PCA9685_DATA_LOW);
}

uint32_t board_read_pca9685(const struct board* b, uint8_t* out) {
    memcpy(out, b->two_wire.chip, sizeof b->two_wire.chip);
    memcpy(out + FIRST, b->two_wire.outputs, sizeof b->two_wire.outputs);
    return b->two_wire.bursts;
}
