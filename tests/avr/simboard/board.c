// The board's life: load, run, reset, hang; its pins; how deep its stack went.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "inside.h"

enum { PAINT = 0xc5 };  // what RAM holds at power-on, so that the stack's depth shows
static const uint8_t JUMP_TO_SELF[2] = {0xff, 0xcf};  // rjmp .-2

avr_io_t* find_module(avr_t* avr, const char* kind, char name) {
    avr_io_t* io = avr->io_port;
    while (io && (strcmp(io->kind, kind) || (name && ((avr_uart_t*)io)->name != name)))
        io = io->next;
    if (!io) {
        fprintf(stderr, "simboard: no %s in this chip\n", kind);
        abort();
    }
    return io;
}

static void quiet(avr_t* avr, const int level, const char* format, va_list args) {
    (void)avr;
    if (level <= LOG_ERROR) vfprintf(stderr, format, args);
}

static void no_sleep(avr_t* avr, avr_cycle_count_t cycles) {
    (void)avr;  // SLEEP costs simulated time and no wall time
    (void)cycles;
}

static void on_core_reset(avr_t* avr) {
    struct board* b = avr->custom.data;
    b->core_reset(avr);
    b->was_reset = 1;
}

// By default simavr polls every cycle while a low INTn pin (Uno D2, D3) is low: 2 to 7 times
// slower.
static void after_reset(struct board* b) {
    for (uint8_t i = 0; i < EXTINT_COUNT; i++) avr_extint_set_strict_lvl_trig(b->avr, i, 0);
    if (b->hung) memcpy(b->avr->flash + b->hung_at, b->flash_before, sizeof b->flash_before);
    b->hung = b->was_reset = 0;
    wire_after_reset(b);
    two_wire_after_reset(b);
}

struct board* board_open(const char* elf, const char* mcu, uint32_t frequency_hz) {
    elf_firmware_t firmware;
    memset(&firmware, 0, sizeof firmware);
    avr_global_logger_set(quiet);
    if (elf_read_firmware(elf, &firmware)) return NULL;
    struct board* b = calloc(1, sizeof *b);
    b->avr = avr_make_mcu_by_name(mcu);
    if (!b->avr) {
        free(b);
        return NULL;
    }
    avr_init(b->avr);
    snprintf(firmware.mmcu, sizeof firmware.mmcu, "%s", mcu);  // an Arduino ELF does not say
    firmware.frequency = frequency_hz;
    avr_load_firmware(b->avr, &firmware);
    b->avr->sleep = no_sleep;
    b->avr->custom.data = b;
    b->core_reset = b->avr->reset;
    b->avr->reset = on_core_reset;
    b->edges.item_size = sizeof(struct edge);
    wire_attach(b);
    eeprom_attach(b);
    two_wire_attach(b);
    const unsigned first = b->avr->ioend + 1u;
    memset(b->avr->data + first, PAINT, b->avr->ramend + 1u - first);
    after_reset(b);
    return b;
}

void board_close(struct board* b) {
    avr_terminate(b->avr);
    free(b->edges.items);
    free(b->sent.items);
    free(b->wire.queue.items);
    free(b->eeprom.before);
    free(b);
}

static void begin_hang(struct board* b) {
    avr_t* avr = b->avr;
    if (!avr->sreg[S_I]) return;  // in an interrupt: wait until the main program has the processor
    b->hung_at = avr->pc;
    memcpy(b->flash_before, avr->flash + avr->pc, sizeof b->flash_before);
    memcpy(avr->flash + avr->pc, JUMP_TO_SELF, sizeof JUMP_TO_SELF);
    b->hang_wanted = 0;
    b->hung = 1;
}

int board_run(struct board* b, uint64_t until_cycle) {
    while (!b->crashed && b->avr->cycle < until_cycle) {
        const int state = avr_run(b->avr);
        b->crashed = state == cpu_Done || state == cpu_Crashed;
        if (b->was_reset) {
            b->counts.resets++;
            after_reset(b);
        }
        if (b->hang_wanted) begin_hang(b);
    }
    return !b->crashed;
}

void board_hang(struct board* b) { b->hang_wanted = 1; }

uint64_t board_cycle(const struct board* b) { return b->avr->cycle; }

void board_reset(struct board* b, enum reset_cause cause) {
    avr_t* avr = b->avr;
    avr_reset(avr);
    const avr_regbit_t flags[] = {avr->reset_flags.porf, avr->reset_flags.extrf,
                                  avr->reset_flags.borf};
    avr_regbit_set(avr, flags[cause]);
    b->counts.resets++;
    after_reset(b);
}

struct board_counts board_counts(const struct board* b) { return b->counts; }

static void on_pin(avr_irq_t* irq, uint32_t value, void* param) {
    (void)irq;
    struct pin* p = param;
    if ((value & 1) == p->level) return;
    p->level = value & 1;
    struct edge e = {p->board->avr->cycle, p->number, p->level};
    growing_push(&p->board->edges, &e);
}

int board_watch(struct board* b, char port, int bit) {
    avr_irq_t* irq = avr_io_getirq(b->avr, AVR_IOCTL_IOPORT_GETIRQ((uint32_t)port), bit);
    if (!irq || b->n_pins == MAX_PINS) return -1;
    struct pin* p = &b->pins[b->n_pins];
    *p = (struct pin){b, b->n_pins, 0};
    avr_irq_register_notify(irq, on_pin, p);
    return (int)b->n_pins++;
}

size_t board_take_edges(struct board* b, struct edge* out, size_t room) {
    return growing_take(&b->edges, out, room);
}

size_t board_take_sent(struct board* b, struct sent_byte* out, size_t room) {
    return growing_take(&b->sent, out, room);
}

void board_read_ram(const struct board* b, uint16_t address, uint8_t* out, size_t n) {
    memcpy(out, b->avr->data + address, n);
}
