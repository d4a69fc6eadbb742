/* SPDX-License-Identifier: MIT */
#include "history.h"

#include <stdlib.h>
#include <string.h>

static void clear(struct history_list *list)
{
    for (int i = 0; i < list->count; i++)
        free(list->steps[i].text);
    *list = (struct history_list) { .count = 0 };
}

static void push(struct history_list *list, struct history_step added)
{
    size_t size = strlen(added.text) + 1;
    int drop = 0;
    while (drop < list->count && (list->count - drop == HISTORY_MOST_STEPS || list->bytes + size > HISTORY_MOST_BYTES)) {
        list->bytes -= strlen(list->steps[drop].text) + 1;
        free(list->steps[drop++].text);
    }
    memmove(list->steps, list->steps + drop, (size_t)(list->count - drop) * sizeof *list->steps);
    list->count -= drop;
    list->steps[list->count++] = added;
    list->bytes += size;
}

static struct history_step pop(struct history_list *list)
{
    if (list->count == 0)
        return (struct history_step) { .text = NULL };
    struct history_step step = list->steps[--list->count];
    list->bytes -= strlen(step.text) + 1;
    return step;
}

void history_finish(struct history *history)
{
    clear(&history->undo);
    clear(&history->redo);
}

bool history_begins(const struct history *history, int client, int64_t gesture)
{
    return gesture == 0 || history->client != client || history->gesture != gesture;
}

void history_push(struct history *history, int client, int64_t gesture, struct history_step before)
{
    clear(&history->redo);
    push(&history->undo, before);
    history->client = gesture ? client : 0;
    history->gesture = gesture;
}

static struct history_step go(struct history *history, struct history_list *from, struct history_list *to, struct history_step now)
{
    struct history_step step = pop(from);
    history->client = 0;
    if (step.text)
        push(to, now);
    else
        free(now.text);
    return step;
}

struct history_step history_undo(struct history *history, struct history_step now)
{
    return go(history, &history->undo, &history->redo, now);
}

struct history_step history_redo(struct history *history, struct history_step now)
{
    return go(history, &history->redo, &history->undo, now);
}

int history_drop(struct history *history, int direction, bool (*same)(const char *text, const void *user), const void *user)
{
    struct history_list *beyond = direction < 0 ? &history->undo : &history->redo;
    int count = 0;
    free(pop(direction < 0 ? &history->redo : &history->undo).text);
    for (; same && beyond->count && same(beyond->steps[beyond->count - 1].text, user); count++)
        free(pop(beyond).text);
    return count;
}
