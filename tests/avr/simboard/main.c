// Run the simulated board behind a pseudo-terminal that a serial program opens like a real port.
// SIGUSR1 presses its reset button, SIGUSR2 hangs its program, SIGTERM unplugs it.
#define _GNU_SOURCE
#include <fcntl.h>
#include <getopt.h>
#include <poll.h>
#include <pty.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

#include "simboard.h"

static volatile sig_atomic_t unplugged, reset_pressed, hang_wanted;

struct options {
    const char *elf, *mcu, *link, *eeprom, *edges, *pins;
    double speed, boot_s;
    uint32_t frequency_hz, baud;
    int keep_running;  // do not reset when the port is opened
};

struct port {
    int master, open;
    double held_until_s;  // the boot loader's time, during which the program does not run
};

static const char USAGE[] =
    "usage: simboard --pty LINK [--mcu NAME] [--frequency HZ] [--baud N] [--eeprom FILE]\n"
    "                [--pins D3D5... --edges FILE] [--speed X (0: as fast as it goes)]\n"
    "                [--boot-s S] [--no-reset-on-open] firmware.elf\n";

static void on_signal(int s) {
    if (s == SIGUSR1)
        reset_pressed = 1;
    else if (s == SIGUSR2)
        hang_wanted = 1;
    else
        unplugged = 1;
}

static double now_s(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + (double)t.tv_nsec * 1e-9;
}

static void sleep_s(double s) {
    if (s <= 0) return;
    struct timespec t = {(time_t)s, (long)((s - (double)(time_t)s) * 1e9)};
    nanosleep(&t, NULL);
}

static int parse(int argc, char** argv, struct options* o) {
    static const struct option names[] = {{"mcu", 1, 0, 'm'},    {"frequency", 1, 0, 'f'},
                                          {"pty", 1, 0, 'p'},    {"eeprom", 1, 0, 'r'},
                                          {"edges", 1, 0, 'e'},  {"speed", 1, 0, 'x'},
                                          {"boot-s", 1, 0, 'b'}, {"baud", 1, 0, 'd'},
                                          {"pins", 1, 0, 'n'},   {"no-reset-on-open", 0, 0, 'k'},
                                          {0, 0, 0, 0}};
    *o = (struct options){
        .mcu = "atmega328p", .pins = "", .speed = 1, .frequency_hz = 16000000, .baud = 250000};
    for (int c; (c = getopt_long(argc, argv, "", names, NULL)) != -1;) {
        if (c == 'm')
            o->mcu = optarg;
        else if (c == 'f')
            o->frequency_hz = (uint32_t)strtoul(optarg, NULL, 10);
        else if (c == 'p')
            o->link = optarg;
        else if (c == 'r')
            o->eeprom = optarg;
        else if (c == 'e')
            o->edges = optarg;
        else if (c == 'n')
            o->pins = optarg;
        else if (c == 'x')
            o->speed = strtod(optarg, NULL);
        else if (c == 'b')
            o->boot_s = strtod(optarg, NULL);
        else if (c == 'd')
            o->baud = (uint32_t)strtoul(optarg, NULL, 10);
        else if (c == 'k')
            o->keep_running = 1;
        else
            return 0;
    }
    if (optind + 1 != argc || !o->link) return 0;
    o->elf = argv[optind];
    return 1;
}

static int open_port(const char* link, struct port* p) {
    int slave;
    char name[128];
    struct termios raw;
    if (openpty(&p->master, &slave, name, NULL, NULL)) return 0;
    tcgetattr(slave, &raw);
    cfmakeraw(&raw);
    tcsetattr(slave, TCSANOW, &raw);
    close(slave);  // so that POLLHUP on the master tells whether a client has it open
    fcntl(p->master, F_SETFL, O_NONBLOCK);
    unlink(link);
    return !symlink(name, link);
}

static void restart(struct board* b, struct port* p, const struct options* o) {
    board_reset(b, RESET_EXTERNAL);
    p->held_until_s = now_s() + o->boot_s;
}

static void to_host(struct board* b, const struct port* p) {
    struct sent_byte sent[256];
    uint8_t bytes[256];
    for (size_t n; (n = board_take_sent(b, sent, 256)) > 0;) {
        for (size_t i = 0; i < n; i++) bytes[i] = (uint8_t)sent[i].value;
        // A host that does not read loses what does not fit, as with a USB-serial chip.
        if (p->open && write(p->master, bytes, n) < 0) continue;
    }
}

static void from_host(struct board* b, struct port* p, const struct options* o) {
    struct pollfd state = {.fd = p->master, .events = POLLIN};
    if (poll(&state, 1, 0) < 0) return;
    const int open_now = !(state.revents & POLLHUP);
    if (open_now && !p->open && !o->keep_running) restart(b, p, o);
    p->open = open_now;
    if (!(state.revents & POLLIN)) return;
    uint8_t bytes[256];
    const ssize_t n = read(p->master, bytes, sizeof bytes);
    if (n > 0 && now_s() >= p->held_until_s) board_wire(b, 0, o->baud, bytes, (size_t)n);
}

static void log_edges(struct board* b, FILE* log) {
    struct edge e;
    while (board_take_edges(b, &e, 1))
        if (log) fprintf(log, "%llu,%u,%u\n", (unsigned long long)e.cycle, e.pin, e.level);
}

static enum board_state serve(struct board* b, struct port* p, const struct options* o, FILE* log) {
    const uint64_t slice = o->frequency_hz / 1000;
    const double slice_s = o->speed > 0 ? 1e-3 / o->speed : 0, most_behind_s = 0.2;
    enum board_state state = BOARD_RUNNING;
    double due_s = now_s();
    while (!unplugged && state == BOARD_RUNNING) {
        from_host(b, p, o);
        if (reset_pressed) restart(b, p, o);
        if (hang_wanted) board_hang(b);
        reset_pressed = hang_wanted = 0;
        if (now_s() >= p->held_until_s) state = board_run(b, board_cycle(b) + slice);
        to_host(b, p);
        log_edges(b, log);
        due_s += slice_s;
        const double lag_s = now_s() - due_s;
        if (lag_s > most_behind_s) due_s += lag_s;  // a stalled machine: go on from now, no burst
        if (o->speed > 0) sleep_s(-lag_s);
    }
    return state;
}

static void load_eeprom(struct board* b, const char* path) {
    uint8_t bytes[4096];
    FILE* f = path ? fopen(path, "rb") : NULL;
    if (!f) return;
    if (fread(bytes, 1, sizeof bytes, f) == board_eeprom_size(b)) board_write_eeprom(b, bytes);
    fclose(f);
}

static int save_eeprom(struct board* b, const char* path) {
    uint8_t bytes[4096];
    if (!path) return 1;
    FILE* f = fopen(path, "wb");
    if (!f) return 0;
    board_read_eeprom(b, bytes);
    const size_t n = board_eeprom_size(b);
    const int written = fwrite(bytes, 1, n, f) == n;
    return !fclose(f) && written;
}

// Pins as letters and bits, in the order of the servos: D3D5D6B1B2.
static int watch_pins(struct board* b, const char* pins) {
    for (; *pins; pins += 2)
        if (!pins[1] || board_watch(b, pins[0], pins[1] - '0') < 0) return 0;
    return 1;
}

int main(int argc, char** argv) {
    struct options o;
    struct port p = {.master = -1};
    if (!parse(argc, argv, &o)) {
        fputs(USAGE, stderr);
        return 2;
    }
    struct board* b = board_open(o.elf, o.mcu, o.frequency_hz);
    if (!b || !watch_pins(b, o.pins) || !open_port(o.link, &p)) {
        fprintf(stderr, "simboard: cannot run %s on %s behind %s\n", o.elf, o.mcu, o.link);
        return 1;
    }
    load_eeprom(b, o.eeprom);
    const int signals[] = {SIGINT, SIGTERM, SIGUSR1, SIGUSR2};
    for (int i = 0; i < 4; i++) signal(signals[i], on_signal);
    FILE* log = o.edges ? fopen(o.edges, "w") : NULL;
    const enum board_state state = serve(b, &p, &o, log);
    if (log) fclose(log);
    unlink(o.link);
    const int saved = save_eeprom(b, o.eeprom);
    board_close(b);
    return state == BOARD_RUNNING && saved ? 0 : 1;
}
