/* SPDX-License-Identifier: MIT */
/* A picture's way out: encoded, with a header that tells what it is of. */
#include <stdlib.h>
#include <string.h>

#include "session_inside.h"

void session_note_clients(const struct session *s, struct frame_facts *facts, bool slices)
{
    facts->client_count = 0;
    for (int i = 0; i < SESSION_MOST_CLIENTS; i++)
        if (s->clients[i].number && s->clients[i].greeted && (s->clients[i].slices || !slices)) {
            facts->clients[facts->client_count] = s->clients[i].number;
            facts->ids[facts->client_count++] = s->clients[i].id;
        }
}

static uint64_t counter(const struct pel_frame_stats *stats, const char *name)
{
    for (int i = 0; i < stats->counter_count; i++)
        if (strcmp(stats->counters[i].name, name) == 0)
            return stats->counters[i].value;
    return 0;
}

/* Of a picture at rest: all of it is the background. */
static bool shows_nothing(const struct pel_image *image)
{
    const size_t count = (size_t)image->width * (size_t)image->height;
    size_t i = 0;
    while (i < count && !(image->rgba[4 * i + 3] > 0))
        i++;
    return i == count;
}

static char *header_text(const struct frame_facts *f, const struct session_frame *frame, const struct pel_image *image)
{
    const struct pel_frame_stats *stats = f->stats;
    char device[256];
    snprintf(device, sizeof device, "%s%s%s, %d thread%s", strcmp(stats->device, "cpu") ? stats->device : "CPU", stats->isa ? " " : "",
             stats->isa ? stats->isa : "", stats->threads, stats->threads == 1 ? "" : "s");
    json_t *json = json_pack(
        "{s:I, s:s, s:s, s:[i, i], s:[i, i], s:s, s:b, s:b, s:b, s:o, s:s, s:s, s:I, s:I}", "frame", (json_int_t)frame->number, "view",
        f->view, "type", f->final ? "image/png" : "image/jpeg", "size", image->width, image->height, "of", f->of[0], f->of[1], "quality",
        f->quality, "lossless", (int)f->final, "final", (int)f->final, "empty", f->final && shows_nothing(image), "camera",
        session_camera_json(&f->scene->camera), "technique", stats->technique ? stats->technique : "", "device", device, "samples",
        (json_int_t)counter(stats, "samples taken"), "averaged", (json_int_t)counter(stats, "frames averaged"));
    char *text = json_dumps(json, JSON_COMPACT | JSON_REAL_PRECISION(17));
    json_decref(json);
    return text;
}

bool session_send_frame(struct session *s, struct encoder *encoder, const struct pel_image *image, struct frame_facts *f,
                        const struct pel_progress *progress, struct pel_error *error)
{
    double start = session_now();
    struct session_frame frame = { .view = f->view, .lossless = f->final, .client_count = f->client_count };
    bool fine =
        f->final ? encode_png(encoder, image, f->scene->background, false, progress, &frame.bytes, &frame.size, error)
                 : encode_jpeg(encoder, image, f->scene->background, strcmp(f->quality, "moving") != 0, &frame.bytes, &frame.size, error);
    if (!fine)
        return false;
    frame.number = ++s->frames;
    for (int i = 0; i < f->client_count; i++) {
        frame.clients[i].client = f->clients[i];
        frame.clients[i].id = f->ids[i];
    }
    frame.draw_ms = f->draw_ms;
    frame.encode_ms = session_now() - start;
    char *header = header_text(f, &frame, image);
    frame.header = header;
    if (header && s->params.frame)
        s->params.frame(s->params.user, &frame);
    free(header);
    return true;
}
