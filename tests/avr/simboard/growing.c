// An array that grows, for what a run records.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "inside.h"

void growing_push(struct growing* g, const void* item) {
    if (g->n == g->room) {
        g->room = g->room ? 2 * g->room : 1024;
        g->items = realloc(g->items, g->room * g->item_size);
        if (!g->items) {
            perror("simboard: recording");
            abort();
        }
    }
    memcpy((char*)g->items + g->n++ * g->item_size, item, g->item_size);
}

size_t growing_take(struct growing* g, void* out, size_t room) {
    size_t n = g->n < room ? g->n : room;
    if (!n) return 0;
    memcpy(out, g->items, n * g->item_size);
    g->n -= n;
    memmove(g->items, (char*)g->items + n * g->item_size, g->n * g->item_size);
    return n;
}
