/* Growing records of a run. */
#include "record/record.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* make room for `count` items of `size` bytes where the pointer in `slot` points; 0, or 1 when memory runs out */
static int grow(void *slot, size_t count, size_t size)
{
    void *items;
    memcpy(&items, slot, sizeof items);
    items = realloc(items, count * size);
    if (!items)
        return 1;
    memcpy(slot, &items, sizeof items);
    return 0;
}

int append_row(struct record *r, double t, const double *y, size_t size, const double *latched, size_t latches)
{
    const size_t width = size + latches;
    if (r->count == r->room) {
        const size_t room = r->room ? 2 * r->room : 256;
        if (grow(&r->t, room, sizeof *r->t) || grow(&r->y, room * width, sizeof *r->y) ||
            grow(&r->events, room, sizeof *r->events))
            return 1;
        r->room = room;
    }
    r->t[r->count] = t;
    memcpy(r->y + r->count * width, y, size * sizeof *y);
    if (latches)
        memcpy(r->y + r->count * width + size, latched, latches * sizeof *y);
    const int known = r->count && r->t[r->count - 1] == r->told_from && t == r->told_to;
    r->events[r->count] = known ? r->told : UCHAR_MAX;
    r->count++;
    return 0;
}

int append_impact(struct impacts *r, double t, const double *u_minus, const double *u_plus, size_t n, int count,
                  const int *contact, const double *impulse, double energy_loss, double share, size_t after)
{
    if (r->count == r->room) {
        const size_t room = r->room ? 2 * r->room : 64;
        if (grow(&r->t, room, sizeof *r->t) || grow(&r->energy_loss, room, sizeof *r->energy_loss) ||
            grow(&r->share, room, sizeof *r->share) || grow(&r->first, room + 1, sizeof *r->first) ||
            grow(&r->after, room, sizeof *r->after) || grow(&r->u_minus, room * n, sizeof *r->u_minus) ||
            grow(&r->u_plus, room * n, sizeof *r->u_plus))
            return 1;
        r->room = room;
    }
    if (r->contact_count + count > r->contact_room) {
        const size_t room = 2 * (r->contact_count + count) + 64;
        if (grow(&r->contact, room, sizeof *r->contact) || grow(&r->impulse, room, sizeof *r->impulse) ||
            grow(&r->friction, room, sizeof *r->friction))
            return 1;
        r->contact_room = room;
    }
    r->t[r->count] = t;
    r->energy_loss[r->count] = energy_loss;
    r->share[r->count] = share;
    r->after[r->count] = after;
    memcpy(r->u_minus + r->count * n, u_minus, n * sizeof *u_minus);
    memcpy(r->u_plus + r->count * n, u_plus, n * sizeof *u_plus);
    r->first[r->count] = r->contact_count;
    for (int i = 0; i < count; i++) {
        r->contact[r->contact_count] = contact[i];
        r->friction[r->contact_count] = impulse[count + i];
        r->impulse[r->contact_count++] = impulse[i];
    }
    r->first[++r->count] = r->contact_count;
    return 0;
}

/* Whether contacts are held as the last record says, or apart where there is none yet */
static int held_as_before(const struct mode_history *r, int contacts, const signed char *mode)
{
    size_t next = r->count ? r->first[r->count - 1] : r->contact_count;
    for (int c = 0; c < contacts; c++) {
        const int listed = next < r->contact_count && r->contact[next] == c;
        if (mode[c] != (listed ? r->mode[next] : OPEN))
            return 0;
        next += listed;
    }
    return 1;
}

int append_modes(struct mode_history *r, double t, int contacts, const signed char *mode)
{
    if (held_as_before(r, contacts, mode))
        return 0;
    if (r->count == r->room) {
        const size_t room = r->room ? 2 * r->room : 64;
        if (grow(&r->t, room, sizeof *r->t) || grow(&r->first, room + 1, sizeof *r->first))
            return 1;
        r->room = room;
    }
    if (r->contact_count + contacts > r->contact_room) {
        const size_t room = 2 * (r->contact_count + contacts) + 64;
        if (grow(&r->contact, room, sizeof *r->contact) || grow(&r->mode, room, sizeof *r->mode))
            return 1;
        r->contact_room = room;
    }
    r->t[r->count] = t;
    r->first[r->count] = r->contact_count;
    for (int c = 0; c < contacts; c++)
        if (mode[c] != OPEN) {
            r->contact[r->contact_count] = c;
            r->mode[r->contact_count++] = mode[c];
        }
    r->first[++r->count] = r->contact_count;
    return 0;
}

int open_stepping(struct stepping *r, double t, size_t rows)
{
    if (r->count && r->t1[r->count - 1] == t && r->last[r->count - 1] == rows - 1)
        return 0;
    if (r->count == r->room) {
        const size_t room = r->room ? 2 * r->room : 64;
        if (grow(&r->t0, room, sizeof *r->t0) || grow(&r->t1, room, sizeof *r->t1) ||
            grow(&r->step, room, sizeof *r->step) || grow(&r->miss, room, sizeof *r->miss) ||
            grow(&r->first, room, sizeof *r->first) || grow(&r->last, room, sizeof *r->last))
            return 1;
        r->room = room;
    }
    r->t0[r->count] = r->t1[r->count] = t;
    r->step[r->count] = 0.0;
    r->miss[r->count] = 0.0;
    r->first[r->count] = r->last[r->count] = rows - 1;
    r->count++;
    return 0;
}

int note_stepping(struct stepping *r, double t, double h, double miss, double jump, size_t rows)
{
    const size_t i = r->count - 1;
    if (rows > r->jump_room) {
        if (grow(&r->jump, 2 * rows, sizeof *r->jump))
            return 1;
        r->jump_room = 2 * rows;
    }
    r->jump[rows - 1] = jump;
    r->t1[i] = t;
    r->step[i] = fmax(r->step[i], h);
    r->miss[i] += miss;
    r->last[i] = rows - 1;
    return 0;
}
