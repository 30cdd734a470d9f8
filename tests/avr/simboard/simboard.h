// An Arduino board in libsimavr: its serial wire, pins, EEPROM, resets and stack, all stamped in
// CPU cycles.
//
// What simavr leaves out and this adds: bytes at true wire pace that overrun the receiver as they
// do on silicon, EEPROM writes that take their 3.4 ms, a program that hangs.
#pragma once
#include <stddef.h>
#include <stdint.h>

struct board;

enum reset_cause { RESET_POWER_ON, RESET_EXTERNAL, RESET_BROWN_OUT };
// What ails a PCA9685: no power (it comes back as at power-up); it holds the data wire low.
enum pca9685_fault {
    PCA9685_WELL,
    PCA9685_SILENT,
    PCA9685_DATA_LOW,
};

struct edge {
    uint64_t cycle;
    uint32_t pin;  // the number board_watch returned
    uint32_t level;
};

struct sent_byte {
    uint64_t cycle;  // when the program handed the byte to the UART
    uint32_t value;
    uint32_t unused;
};

struct board_counts {
    uint32_t resets;         // of any cause, the power-on not counted
    uint32_t overrun_bytes;  // lost because three were waiting unread
    uint32_t
        eeprom_ignored;    // writes begun while the last one was still going on: silicon drops them
    uint32_t twi_misused;  // steps of the two-wire unit begun before the last one had ended
};

struct board* board_open(const char* elf, const char* mcu, uint32_t frequency_hz);
void board_close(struct board* b);

int board_run(struct board* b, uint64_t until_cycle);  // whether the program still runs
uint64_t board_cycle(const struct board* b);
void board_reset(struct board* b, enum reset_cause cause);
void board_hang(
    struct board* b);  // the program loops for ever, interrupts still served, until a reset
struct board_counts board_counts(const struct board* b);

int board_watch(struct board* b, char port,
                int bit);  // returns the pin's number, -1 if there is none
size_t board_take_edges(struct board* b, struct edge* out, size_t room);
size_t board_take_sent(struct board* b, struct sent_byte* out, size_t room);

// Queue bytes on the wire to the board: the first starts at the given cycle or when the wire is
// free.
void board_wire(struct board* b, uint64_t at_cycle, uint32_t baud, const uint8_t* bytes, size_t n);

// A PCA9685 at the two wires, of which one bit of a port is the data.
void board_add_pca9685(struct board* b, char port, int data_bit);
void board_fault_pca9685(struct board* b, enum pca9685_fault fault);
// Its 256 registers, the outputs' as they are in effect; returns how often the outputs changed.
uint32_t board_read_pca9685(const struct board* b, uint8_t* out);

void board_read_ram(const struct board* b, uint16_t address, uint8_t* out, size_t n);
size_t board_eeprom_size(const struct board* b);
void board_read_eeprom(const struct board* b, uint8_t* out);
void board_write_eeprom(struct board* b, const uint8_t* bytes);
