/* SPDX-License-Identifier: MIT */
/* libFuzzer target for the viewer's commands: lines of JSON on a tiny volume, with no folder that may be opened. Nothing but the session's
 * own refusal may come of any. Drawing is real, but of a few pixels and voxels; sizes that a command asks for are bounded by what the session takes, so that large ones are left out here. */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "session.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size);

static void on_event(void *user, int client, const char *text)
{
    (void)user, (void)client;
    json_t *event = json_loads(text, 0, NULL);
    const char *kind = json_string_value(json_object_get(event, "event"));
    if (!kind || (strcmp(kind, "error") == 0 && !json_string_length(json_object_get(event, "message"))))
        abort();
    json_decref(event);
}

static bool open_tiny(void *user, struct session_opened *opened, const struct pel_progress *progress, struct pel_error *error)
{
    (void)user, (void)progress;
    pel_volume_init(&opened->volume);
    if (!pel_volume_allocate(&opened->volume, (size_t[]) { 5, 4, 3 }, PEL_U8, 1, error) || !pel_scene_init(&opened->scene, error))
        return false;
    unsigned char *data = opened->volume.data;
    for (int i = 0; i < 60; i++)
        data[i] = (unsigned char)(i * 37);
    pel_volume_update_range(&opened->volume);
    opened->scene.volume = &opened->volume;
    opened->fit_camera = true;
    return pel_scene_choose(&opened->scene, &(struct pel_scene_parts) { .transfer = true, .slice = true, .camera = true }, 16, 16, error);
}

/* Would it draw more than a fuzzer has time for? */
static bool is_large(const json_t *value)
{
    const char *key;
    json_t *member;
    size_t i;
    if (json_is_number(value))
        return json_number_value(value) > 64 && json_number_value(value) <= 70000;
    json_object_foreach((json_t *)value, key, member)
        if (is_large(member))
            return true;
    json_array_foreach((json_t *)value, i, member)
        if (is_large(member))
            return true;
    return false;
}

static void feed(struct session *session, const char *text, size_t size)
{
    json_t *json = json_loadb(text, size, 0, NULL);
    const char *name = json_string_value(json_object_get(json, "do"));
    const char *device = json_string_value(json_object_get(json, "device"));
    bool skip = name && strcmp(name, "device") == 0 && device && strncmp(device, "gpu", 3) == 0; /* drivers are no business of it */
    if (!skip && !(is_large(json_object_get(json, "size")) || is_large(json_object_get(json, "frames"))))
        session_command_text(session, 1, text, size);
    json_decref(json);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    static const char hello[] = "{\"do\":\"hello\",\"size\":[16,16]}", release[] = "{\"do\":\"release\"}";
    const struct session_params params = { .event = on_event, .open = open_tiny, .threads = 1, .budget_ms = 1 };
    struct session *session = session_create(&params, NULL);
    const char *at = (const char *)bytes, *end = at + size;
    if (!session || !session_settle(session, false))
        abort();
    session_command_text(session, 1, hello, sizeof hello - 1);
    for (int i = 0; i < 16 && at < end; i++) {
        const char *line = memchr(at, '\n', (size_t)(end - at));
        size_t length = line ? (size_t)(line - at) : (size_t)(end - at);
        feed(session, at, length);
        at += length + 1;
    }
    session_command_text(session, 1, release, sizeof release - 1);
    session_settle(session, true); /* what is to be saved is drawn at rest */
    session_destroy(session);
    return 0;
}
