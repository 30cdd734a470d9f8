// A PCA9685 on the board's two wires, by its data sheet: registers that count up, outputs that
// change at the stop, sleep and restart, a rate that is set asleep; and what can happen to it.
#include <string.h>

#include "inside.h"

enum { ADDRESS = 0x40, MODE1 = 0x00, MODE2 = 0x01, PRESCALE = 0xfe };
enum { FIRST = 0x06, LAST = 0x45, ALL = 0xfa, LAST_ALL = 0xfd };
enum { RESTART = 0x80, EXTCLK = 0x40, COUNTS_UP = 0x20, SLEEP = 0x10 };
enum { GENERAL_CALL = 0x00, SOFTWARE_RESET = 0x06 };
enum { FULL_OFF = 0x10, LEAST_PRESCALE = 3 };

static void power_up(struct pca9685* p) {
    memset(p->registers, 0, sizeof p->registers);
    p->registers[MODE1] = 0x11;
    p->registers[MODE2] = 0x04;
    for (int r = FIRST + 3; r <= LAST; r += 4) p->registers[r] = FULL_OFF;
    p->registers[PRESCALE] = 0x1e;
    p->addressed = p->pointed = p->changed = p->bits_left = 0;
    memcpy(p->outputs, p->registers + FIRST, sizeof p->outputs);
}

static int any_output_on(const struct pca9685* p) {
    int on = 0;
    for (int r = FIRST + 3; r <= LAST; r += 4) on |= !(p->registers[r] & FULL_OFF);
    return on;
}

// Falling asleep with outputs on marks them as waiting; a 1 written to that mark, awake, ends it.
static void set_mode1(struct pca9685* p, uint8_t v) {
    uint8_t restart = p->registers[MODE1] & RESTART;
    if ((v & SLEEP) && !(p->registers[MODE1] & SLEEP) && any_output_on(p)) restart = RESTART;
    if ((v & RESTART) && !(v & SLEEP)) restart = 0;
    const uint8_t sticky = p->registers[MODE1] & EXTCLK;
    p->registers[MODE1] = (uint8_t)((v & 0x7f) | restart | sticky);
}

static void set_channel(struct pca9685* p, int r, uint8_t v) {
    const int is_high = (r - FIRST) & 1;
    p->registers[r] = is_high ? v & 0x1f : v;
    p->changed = 1;
}

static void write_register(struct pca9685* p, uint8_t v) {
    const uint8_t r = p->next;
    if (r == MODE1) {
        set_mode1(p, v);
    } else if (r >= FIRST && r <= LAST) {
        set_channel(p, r, v);
    } else if (r >= ALL && r <= LAST_ALL) {
        for (int c = FIRST + r - ALL; c <= LAST; c += 4) set_channel(p, c, v);
    } else if (r == PRESCALE) {
        if (p->registers[MODE1] & SLEEP) p->registers[r] = v < LEAST_PRESCALE ? LEAST_PRESCALE : v;
    } else if (r < FIRST) {
        p->registers[r] = v;
    }
    if (p->registers[MODE1] & COUNTS_UP) p->next = r == LAST ? 0 : (uint8_t)(r + 1);
}

void pca9685_begin(struct pca9685* p) { p->addressed = 0; }

int pca9685_take(struct pca9685* p, uint8_t byte, int is_address) {
    if (p->fault == PCA9685_SILENT) return 0;
    if (p->acks_left && --p->acks_left == 0) return 0;
    if (is_address) {
        p->called = byte == GENERAL_CALL;
        p->addressed = byte >> 1 == ADDRESS || p->called;
        p->pointed = byte & 1;  // a read goes on where the pointer stands
        return p->addressed;
    }
    if (!p->addressed) return 0;
    if (p->called) {
        if (byte == SOFTWARE_RESET) power_up(p);
        return byte == SOFTWARE_RESET;
    }
    if (p->bytes_left && --p->bytes_left == 0) {
        power_up(p);
        p->fault = PCA9685_SILENT;
        return 0;
    }
    if (p->pointed) write_register(p, byte);
    if (!p->pointed) p->next = byte;
    p->pointed = 1;
    return 1;
}

uint8_t pca9685_give(struct pca9685* p) {
    const int hidden = p->next >= ALL && p->next <= LAST_ALL;
    if (!p->addressed || p->fault == PCA9685_SILENT) return 0xff;
    const int restart = p->next == MODE1 && p->fault == PCA9685_RESTART ? RESTART : 0;
    return hidden ? 0 : (uint8_t)(p->registers[p->next] | restart);
}

// Outputs change at the stop, all at once.
void pca9685_end(struct pca9685* p) {
    p->addressed = 0;
    if (!p->changed) return;
    p->changed = 0;
    p->bursts++;
    p->registers[MODE1] &= (uint8_t)~RESTART;
    memcpy(p->outputs, p->registers + FIRST, sizeof p->outputs);
}

int pca9685_holds_data(const struct pca9685* p) {
    return p->fault == PCA9685_DATA_LOW || p->bits_left;
}

static void show_data(struct pca9685* p) {
    if (!p->pins) return;
    *p->pins = (uint8_t)(*p->pins & ~p->data_mask);
    if (!pca9685_holds_data(p)) *p->pins = (uint8_t)(*p->pins | p->data_mask);
}

void pca9685_cut_short(struct pca9685* p, uint8_t bits_left) {
    p->bits_left = bits_left;
    show_data(p);
}

// Pins as outputs pull low, as inputs let the wire rise: a clock made by hand.
static void on_direction(avr_irq_t* irq, uint32_t value, void* param) {
    (void)irq;
    struct pca9685* p = param;
    const int high = !(value & p->clock_mask);
    if (high && !p->clock_high && p->bits_left) p->bits_left--;
    p->clock_high = high;
    show_data(p);
}

void board_add_pca9685(struct board* b, char port, int clock_bit, int data_bit) {
    struct pca9685* p = &b->pca9685;
    power_up(p);
    p->clock_mask = 1u << clock_bit;
    p->clock_high = 1;
    p->fault = PCA9685_WELL;
    p->data_mask = 1u << data_bit;
    p->pins = b->avr->data + ((avr_ioport_t*)find_module(b->avr, "port", port))->r_pin;
    avr_irq_register_notify(
        avr_io_getirq(b->avr, AVR_IOCTL_IOPORT_GETIRQ((uint32_t)port), IOPORT_IRQ_DIRECTION_ALL),
        on_direction, p);
    show_data(p);
}

void board_fault_pca9685(struct board* b, enum pca9685_fault fault, uint32_t after_bytes) {
    struct pca9685* p = &b->pca9685;
    if (fault == PCA9685_NO_ACK) {
        p->acks_left = after_bytes;
        return;
    }
    if (fault == PCA9685_EXTERNAL_CLOCK) {
        p->registers[MODE1] |= EXTCLK;
        return;
    }
    p->bytes_left = after_bytes;
    if (after_bytes) return;
    if (fault == PCA9685_SILENT || p->fault == PCA9685_SILENT) power_up(p);
    p->fault = fault;
    show_data(p);
}

uint32_t board_read_pca9685(const struct board* b, uint8_t* out) {
    memcpy(out, b->pca9685.registers, sizeof b->pca9685.registers);
    memcpy(out + FIRST, b->pca9685.outputs, sizeof b->pca9685.outputs);
    return b->pca9685.bursts;
}
