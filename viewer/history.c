/* SPDX-License-Identifier: MIT */
#include "history.h"

#include <stdlib.h>
#include <string.h>

static void clear(struct history_list *list)
{
    for (int i = 0; i < list->count; i++)
        free(list->texts[i]);
    *list = (struct history_list) { .count = 0 };
}

static void push(struct history_list *list, char *text)
{
    size_t size = strlen(text) + 1;
    int drop = 0;
    while (drop < list->count && (list->count - drop == HISTORY_MOST_STEPS || list->bytes + size > HISTORY_MOST_BYTES)) {
        list->bytes -= strlen(list->texts[drop]) + 1;
        free(list->texts[drop++]);
    }
    memmove(list->texts, list->texts + drop, (size_t)(list->count - drop) * sizeof *list->texts);
    list->count -= drop;
    list->texts[list->count++] = text;
    list->bytes += size;
}

static char *pop(struct history_list *list)
{
    if (list->count == 0)
        return NULL;
    char *text = list->texts[--list->count];
    list->bytes -= strlen(text) + 1;
    return text;
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

void history_push(struct history *history, int client, int64_t gesture, char *before)
{
    clear(&history->redo);
    push(&history->undo, before);
    history->client = gesture ? client : 0;
    history->gesture = gesture;
}

static char *step(struct history *history, struct history_list *from, struct history_list *to, char *now)
{
    char *text = pop(from);
    history->client = 0;
    if (text)
        push(to, now);
    else
        free(now);
    return text;
}

char *history_undo(struct history *history, char *now)
{
    return step(history, &history->undo, &history->redo, now);
}

char *history_redo(struct history *history, char *now)
{
    return step(history, &history->redo, &history->undo, now);
}

int history_drop(struct history *history, int direction, bool (*same)(const char *text, const void *user), const void *user)
{
    struct history_list *beyond = direction < 0 ? &history->undo : &history->redo;
    int count = 0;
    free(pop(direction < 0 ? &history->redo : &history->undo));
    for (; same && beyond->count && same(beyond->texts[beyond->count - 1], user); count++)
        free(pop(beyond));
    return count;
}
