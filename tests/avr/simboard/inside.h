// What the parts of the simulated board share.
#pragma once
#include <simavr/avr_eeprom.h>
#include <simavr/avr_extint.h>
#include <simavr/avr_ioport.h>
#include <simavr/avr_uart.h>
#include <simavr/sim_avr.h>
#include <simavr/sim_cycle_timers.h>
#include <simavr/sim_elf.h>
#include <simavr/sim_io.h>

#include "simboard.h"

enum { MAX_PINS = 16 };

struct growing {
    void* items;
    size_t n, room, item_size;
};

struct wire_byte {
    uint64_t cycle;
    uint8_t value;
};

struct pin {
    struct board* board;
    uint32_t number, level;
};

struct wire {
    avr_uart_t* uart;
    avr_irq_t* input;
    struct growing queue;  // of wire_byte, oldest at `next`
    size_t next;
    uint64_t free_cycle;  // when the last queued byte ends
    uint64_t sent_cycle;  // when the shift register has sent all that it was given
};

struct eeprom {
    avr_eeprom_t* module;
    uint64_t busy_until;
    uint8_t* before;  // its content before the last write
};

struct two_wire {
    uint8_t control, stage, next, changed;  // the step under way; of a job; the register; since it
    uint8_t chip[256], outputs[64];         // registers as written; as the outputs follow them
    uint32_t busy, bursts, bit_cycles;      // a step is under way; changes of outputs; at its pace
    enum pca9685_fault fault;
    avr_irq_t* data_wire;
};

struct board {
    avr_t* avr;
    struct two_wire two_wire;
    void (*core_reset)(avr_t*);
    struct board_counts counts;
    struct pin pins[MAX_PINS];
    uint32_t n_pins;
    struct growing edges, sent;
    struct wire wire;
    struct eeprom eeprom;
    int crashed;
    int was_reset, hang_wanted, hung;
    avr_flashaddr_t hung_at;
    uint8_t flash_before[2];
};

void growing_push(struct growing* g, const void* item);
size_t growing_take(struct growing* g, void* out, size_t room);

avr_io_t* find_module(avr_t* avr, const char* kind, char name);
void wire_attach(struct board* b);
void wire_after_reset(struct board* b);
void eeprom_attach(struct board* b);
void two_wire_attach(struct board* b);
void two_wire_after_reset(struct board* b);
