/* SPDX-License-Identifier: MIT */
#include "record.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "session_inside.h"

bool record_begin(FILE *file, char *const *files, struct pel_error *error)
{
    json_t *list = json_array();
    for (int i = 0; files && files[i]; i++)
        json_array_append_new(list, json_string(files[i]));
    json_t *line = json_pack("{s:i, s:o}", "pellucid-recording", 1, "files", list);
    bool ok = line && json_dumpf(line, file, JSON_COMPACT) == 0 && fputc('\n', file) != EOF && fflush(file) == 0;
    json_decref(line);
    return ok || session_fail(error, PEL_ERROR_IO, "the recording cannot be written: %s", strerror(errno));
}

void record_command(FILE *file, double at_ms, int client, const json_t *command, bool aside)
{
    fprintf(file, "{\"at_ms\": %.3f, \"client\": %d, %s\"command\": ", at_ms, client, aside ? "\"aside\": true, " : "");
    json_dumpf(command, file, JSON_COMPACT | JSON_REAL_PRECISION(17));
    fputs("}\n", file);
    fflush(file);
}

void record_leave(FILE *file, double at_ms, int client)
{
    fprintf(file, "{\"at_ms\": %.3f, \"client\": %d, \"leave\": true}\n", at_ms, client);
    fflush(file);
}

void record_opened(FILE *file, double at_ms, uint64_t entry, bool opened)
{
    fprintf(file, "{\"at_ms\": %.3f, \"%s\": %llu}\n", at_ms, opened ? "opened" : "cancelled", (unsigned long long)entry);
    fflush(file);
}

void record_error(FILE *file, double at_ms, int client, const char *command)
{
    json_t *line = json_pack("{s:f, s:i, s:s}", "at_ms", at_ms, "client", client, "error", command);
    if (line) {
        json_dumpf(line, file, JSON_COMPACT | JSON_REAL_PRECISION(17));
        fputc('\n', file);
        fflush(file);
    }
    json_decref(line);
}

void record_scene(FILE *file, const struct pel_scene *scene, bool fitted)
{
    char *text = pel_scene_to_text(scene, NULL, NULL);
    json_t *json = text ? json_loads(text, 0, NULL) : NULL, *line = json_pack("{s:o, s:b}", "scene", json, "fitted", (int)fitted);
    if (line) {
        json_dumpf(line, file, JSON_COMPACT | JSON_REAL_PRECISION(17));
        fputc('\n', file);
        fflush(file);
    }
    json_decref(line);
    free(text);
}

/* Room for one more in a list whose length doubles. */
static void *grow(void *list, size_t count, size_t size, struct pel_error *error)
{
    void *larger = count & (count - 1) ? list : realloc(list, (count ? 2 * count : 1) * size);
    if (!larger)
        session_fail(error, PEL_ERROR_MEMORY, "no memory for the recording");
    return larger;
}

static bool add_files(struct recording *r, const json_t *list, struct pel_error *error)
{
    const json_t *path;
    size_t i, count = json_array_size(list);
    r->files = calloc(count + 1, sizeof *r->files);
    if (!r->files)
        return session_fail(error, PEL_ERROR_MEMORY, "no memory for the recording");
    json_array_foreach(list, i, path) {
        if (!json_is_string(path))
            return session_fail(error, PEL_ERROR_FORMAT, "files: entry %zu is no text", i + 1);
        if (!(r->files[i] = strdup(json_string_value(path))))
            return session_fail(error, PEL_ERROR_MEMORY, "no memory for the recording");
    }
    return true;
}

static bool add_error(struct recording *r, int client, const char *command, struct pel_error *error)
{
    struct recorded_error *larger = grow(r->errors, r->error_count, sizeof *larger, error);
    if (!larger)
        return false;
    r->errors = larger;
    larger += r->error_count++;
    larger->client = client;
    snprintf(larger->command, sizeof larger->command, "%s", command);
    return true;
}

/* A command, or that a client left, or an error that was told. */
static bool add_entry(struct recording *r, const json_t *line, struct pel_error *error)
{
    json_t *command = json_object_get(line, "command"), *at = json_object_get(line, "at_ms"), *who = json_object_get(line, "client");
    const char *failed = json_string_value(json_object_get(line, "error"));
    bool leaves = json_is_true(json_object_get(line, "leave"));
    if ((!json_is_object(command) && !leaves && !failed) || !json_is_number(at) || !json_is_integer(who) ||
        json_integer_value(who) < (failed ? 0 : 1) || json_integer_value(who) > 1 << 30)
        return session_fail(error, PEL_ERROR_FORMAT, "it is no command: it needs at_ms, client and command (or leave, or error)");
    if (failed)
        return add_error(r, (int)json_integer_value(who), failed, error);
    struct recorded *larger = grow(r->commands, r->count, sizeof *larger, error);
    if (!larger)
        return false;
    r->commands = larger;
    r->commands[r->count++] = (struct recorded) { json_number_value(at), (int)json_integer_value(who), leaves ? NULL : json_incref(command),
                                                  json_is_true(json_object_get(line, "aside")) };
    return true;
}

/* What came of an earlier command that read a file. What undo and redo read says where the camera is, whatever moved it meanwhile. */
static bool add_end(struct recording *r, const json_t *line, struct pel_error *error)
{
    const json_t *opened = json_object_get(line, "opened"), *entry = opened ? opened : json_object_get(line, "cancelled"),
                 *at = json_object_get(line, "at_ms");
    size_t i = json_integer_value(entry) < 0 ? SIZE_MAX : (size_t)json_integer_value(entry);
    const char *name = i < r->count ? json_string_value(json_object_get(r->commands[i].command, "do")) : NULL;
    if (!json_is_integer(entry) || !json_is_number(at) || !name)
        return session_fail(error, PEL_ERROR_FORMAT, "it ends no command that is above");
    if (!opened) {
        r->commands[i].client = 0;
    } else if (strcmp(name, "open") == 0) {
        struct recorded moved = r->commands[i];
        moved.at_ms = json_number_value(at);
        memmove(&r->commands[i], &r->commands[i + 1], (r->count - i - 1) * sizeof moved);
        r->commands[r->count - 1] = moved;
    } else {
        for (i++; i < r->count; i++)
            if (r->commands[i].aside)
                r->commands[i].client = 0;
    }
    return true;
}

static bool add_line(struct recording *r, const json_t *line, bool first, struct pel_error *error)
{
    const json_t *scene = json_object_get(line, "scene");
    if (first && json_integer_value(json_object_get(line, "pellucid-recording")) != 1)
        return session_fail(error, PEL_ERROR_FORMAT, "it is no recording of version 1 of `pellucid view --record`");
    if (first)
        return add_files(r, json_object_get(line, "files"), error);
    if (json_object_get(line, "opened") || json_object_get(line, "cancelled"))
        return add_end(r, line, error);
    if (!scene)
        return add_entry(r, line, error);
    if (r->scene)
        return session_fail(error, PEL_ERROR_FORMAT, "a second scene to begin with");
    r->scene = json_dumps(scene, JSON_COMPACT | JSON_REAL_PRECISION(17));
    r->fitted = json_is_true(json_object_get(line, "fitted"));
    return r->scene || session_fail(error, PEL_ERROR_MEMORY, "no memory for the scene");
}

bool recording_read(const char *path, struct recording *recording, struct pel_error *error)
{
    FILE *file = fopen(path, "r");
    char *text = NULL;
    size_t room = 0, number = 0;
    ssize_t length;
    bool fine = true;
    *recording = (struct recording) { .scene = NULL };
    if (!file)
        return session_fail(error, PEL_ERROR_IO, "%.300s: %s", path, strerror(errno));
    while (fine && (length = getline(&text, &room, file)) > 0) {
        struct pel_error why = PEL_ERROR_INIT;
        json_error_t e;
        json_t *line = json_loadb(text, (size_t)length, JSON_REJECT_DUPLICATES, &e);
        fine = line ? add_line(recording, line, number == 0, &why) : session_fail(&why, PEL_ERROR_FORMAT, "no JSON: %.160s", e.text);
        json_decref(line);
        number++;
        if (!fine)
            session_fail(error, why.code, "%.200s: line %zu: %.250s", path, number, why.message);
    }
    if (fine && number == 0)
        fine = session_fail(error, PEL_ERROR_FORMAT, "%.300s: it is empty", path);
    free(text);
    fclose(file);
    if (!fine)
        recording_finish(recording);
    return fine;
}

void recording_finish(struct recording *recording)
{
    free(recording->scene);
    for (size_t i = 0; i < recording->count; i++)
        json_decref(recording->commands[i].command);
    free(recording->commands);
    free(recording->errors);
    for (size_t i = 0; recording->files && recording->files[i]; i++)
        free(recording->files[i]);
    free(recording->files);
    *recording = (struct recording) { .scene = NULL };
}
