// EEPROM that takes its time: what is written meanwhile is lost.
#include <stdlib.h>
#include <string.h>

#include "inside.h"

static const double WRITE_S = 3.4e-3;  // ATmega328P and 2560 data sheets: erase and write, 3.4 ms

static size_t address_now(const struct board* b) {
    const avr_eeprom_t* m = b->eeprom.module;
    return ((size_t)b->avr->data[m->r_eearl] | (size_t)b->avr->data[m->r_eearh] << 8) % m->size;
}

// Runs after simavr's own handler, which stores the byte at once.
static void on_control(avr_t* avr, avr_io_addr_t addr, uint8_t v, void* param) {
    (void)addr;
    struct board* b = param;
    struct eeprom* e = &b->eeprom;
    if (!(v & 1u << e->module->eepe.bit)) return;
    const size_t at = address_now(b);
    if (avr->cycle < e->busy_until) {
        b->counts.eeprom_ignored++;
        e->module->eeprom[at] = e->before[at];
        return;
    }
    e->busy_until = avr->cycle + (uint64_t)(WRITE_S * avr->frequency);
    e->before[at] = e->module->eeprom[at];
}

static uint8_t control_read(avr_t* avr, avr_io_addr_t addr, void* param) {
    const struct board* b = param;
    const unsigned eepe = 1u << b->eeprom.module->eepe.bit;
    const unsigned busy = avr->cycle < b->eeprom.busy_until ? eepe : 0;
    return (uint8_t)((avr->data[addr] & ~eepe) | busy);
}

size_t board_eeprom_size(const struct board* b) { return b->eeprom.module->size; }

void board_read_eeprom(const struct board* b, uint8_t* out) {
    memcpy(out, b->eeprom.module->eeprom, b->eeprom.module->size);
}

void board_write_eeprom(struct board* b, const uint8_t* bytes) {
    memcpy(b->eeprom.module->eeprom, bytes, b->eeprom.module->size);
    memcpy(b->eeprom.before, bytes, b->eeprom.module->size);
}

void eeprom_attach(struct board* b) {
    struct eeprom* e = &b->eeprom;
    e->module = (avr_eeprom_t*)find_module(b->avr, "eeprom", 0);
    e->before = malloc(e->module->size);
    memcpy(e->before, e->module->eeprom, e->module->size);
    avr_register_io_write(b->avr, e->module->r_eecr, on_control, b);
    avr_register_io_read(b->avr, e->module->r_eecr, control_read, b);
}
