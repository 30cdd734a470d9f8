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

enum twi_step { TWI_NOTHING, TWI_STARTS, TWI_SENDS, TWI_RECEIVES, TWI_STOPS };

struct twi {
    enum twi_step doing;
    uint64_t begun_cycle, bit_cycles;  // of what it does
    uint8_t status, byte;
    int owned, addressing, reading;  // the bus is ours; an address comes next; the chip sends
};

struct pca9685 {
    uint8_t registers[256], outputs[64];  // as written; as the outputs follow them
    uint8_t addressed, pointed, next;     // it was addressed; it has a register; which
    uint8_t called;                       // all chips were, by the general call
    uint8_t changed, bits_left;           // since the stop; of a byte that was cut off
    enum pca9685_fault fault;
    uint32_t bursts, bytes_left;  // changes of outputs; until it falls silent, 0 = never
    uint32_t acks_left;           // until one is lost, 0 = never
    uint32_t clock_mask, data_mask;
    int clock_high;
    uint8_t* pins;  // what the board reads of the port that has both wires
};

struct board {
    avr_t* avr;
    struct twi twi;
    struct pca9685 pca9685;
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
void twi_attach(struct board* b);
void twi_after_reset(struct board* b);

// The chip's end of the wires: a start, a byte from the master (returns whether it acknowledges), a
// byte for the master, a stop.
void pca9685_begin(struct pca9685* p);
int pca9685_take(struct pca9685* p, uint8_t byte, int is_address);
uint8_t pca9685_give(struct pca9685* p);
void pca9685_end(struct pca9685* p);
int pca9685_holds_data(const struct pca9685* p);
// The master is gone in the middle of a byte that the chip sends: it waits for so many clocks.
void pca9685_cut_short(struct pca9685* p, uint8_t bits_left);
