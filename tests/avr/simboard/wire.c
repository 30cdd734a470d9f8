// The serial wire: bytes reach the receiver at the host's pace and overrun it as on silicon; the
// sender has a byte in the shift register and one behind it, where simavr has one in all.
#include "inside.h"

DEFINE_FIFO(uint16_t, uart_fifo);

enum { BITS_PER_BYTE = 10, UNREAD_ON_SILICON = 3 };  // two in the FIFO, one in the shift register

// As the program has set its UART.
static double baud(const struct board* b) {
    const avr_uart_t* u = b->wire.uart;
    const unsigned ubrr = b->avr->data[u->ubrrl.reg] | (b->avr->data[u->ubrrh.reg] & 0xfu) << 8;
    return (double)b->avr->frequency / (avr_regbit_get(b->avr, u->u2x) ? 8 : 16) / (ubrr + 1);
}

// simavr counts 11 bits a byte; 8N1 has 10. Set it right each time the UART is about to use it.
static void true_pace(struct board* b) {
    avr_uart_t* u = b->wire.uart;
    u->cycles_per_byte = (avr_cycle_count_t)(BITS_PER_BYTE * (double)b->avr->frequency / baud(b));
}

static avr_cycle_count_t ready_to_send(avr_t* avr, avr_cycle_count_t when, void* param) {
    (void)when;
    avr_raise_interrupt(avr, &((struct board*)param)->wire.uart->udrc);
    return 0;
}

static void write_data(avr_t* avr, avr_io_addr_t addr, uint8_t value, void* param) {
    (void)addr;
    struct board* b = param;
    struct wire* w = &b->wire;
    if (!avr_regbit_get(avr, w->uart->txen)) return;
    struct sent_byte s = {avr->cycle, value, 0};
    growing_push(&b->sent, &s);
    true_pace(b);
    avr_clear_interrupt(avr, &w->uart->udrc);
    avr_regbit_clear(avr, w->uart->udrc.raised);
    const uint64_t start = w->sent_cycle > avr->cycle ? w->sent_cycle : avr->cycle + 1;
    w->sent_cycle = start + w->uart->cycles_per_byte;
    avr_cycle_timer_register(avr, start - avr->cycle, ready_to_send, b);
}

static avr_cycle_count_t wire_tick(avr_t* avr, avr_cycle_count_t when, void* param) {
    (void)avr;
    (void)when;
    struct board* b = param;
    struct wire* w = &b->wire;
    const struct wire_byte* queue = w->queue.items;
    true_pace(b);
    const unsigned unread = uart_fifo_get_read_size(&w->uart->input);
    if (unread < UNREAD_ON_SILICON) {
        avr_raise_irq(w->input, queue[w->next].value);
    } else {
        b->counts.overrun_bytes++;
    }
    if (++w->next < w->queue.n) return queue[w->next].cycle;
    w->next = w->queue.n = 0;
    return 0;
}

static void start_ticking(struct board* b) {
    const struct wire* w = &b->wire;
    if (w->next == w->queue.n || avr_cycle_timer_status(b->avr, wire_tick, b)) return;
    const uint64_t due = ((struct wire_byte*)w->queue.items)[w->next].cycle;
    const uint64_t delay = due > b->avr->cycle ? due - b->avr->cycle : 1;
    avr_cycle_timer_register(b->avr, delay, wire_tick, b);
}

void board_wire(struct board* b, uint64_t at, uint32_t baud, const uint8_t* bytes, size_t n) {
    struct wire* w = &b->wire;
    const double byte_cycles = BITS_PER_BYTE * (double)b->avr->frequency / baud;
    uint64_t start = at > b->avr->cycle ? at : b->avr->cycle;
    if (start < w->free_cycle) start = w->free_cycle;
    for (size_t i = 0; i < n; i++) {
        struct wire_byte byte = {start + (uint64_t)((double)i * byte_cycles), bytes[i]};
        growing_push(&w->queue, &byte);
    }
    w->free_cycle = start + (uint64_t)((double)n * byte_cycles);
    start_ticking(b);
}

void wire_after_reset(struct board* b) {
    b->wire.sent_cycle = 0;
    start_ticking(b);  // the host goes on sending; the reset cancelled every cycle timer
}

void wire_attach(struct board* b) {
    avr_t* avr = b->avr;
    b->wire.queue.item_size = sizeof(struct wire_byte);
    b->sent.item_size = sizeof(struct sent_byte);
    b->wire.uart = (avr_uart_t*)find_module(avr, "uart", '0');
    b->wire.input = avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_INPUT);
    uint32_t flags = 0;  // neither echo on stdout nor sleeping while the program polls
    avr_ioctl(avr, AVR_IOCTL_UART_SET_FLAGS('0'), &flags);
    const avr_io_addr_t data = AVR_DATA_TO_IO(b->wire.uart->r_udr);
    avr->io[data].w.c = write_data;
    avr->io[data].w.param = b;
}
