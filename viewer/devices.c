/* SPDX-License-Identifier: MIT */
/* What draws, and choosing another while the session runs. Devices are listed by a thread that reads files, after the first picture's
 * needs, for that can take a second; another one is made by the thread that draws, between two pictures. Where it cannot be made the old
 * one stays. */
#include <stdlib.h>
#include <string.h>

#include "session_inside.h"

static json_t *row(const struct pel_device_info *info, const char *id, int threads)
{
    return json_pack("{s:s, s:s, s:s, s:i}", "id", id, "name", info ? info->name : "CPU", "kind",
                     !info            ? "cpu"
                     : info->software ? "software"
                                      : "gpu",
                     "threads", threads);
}

json_t *session_device_json(const struct session *s)
{
    const struct pel_device_info *now = s->device ? pel_device_describe(s->device) : NULL;
    char id[32] = "gpu";
    for (int i = 0; now && i < s->devices.count; i++)
        if (strcmp(now->name, s->devices.infos[i].name) == 0 && strcmp(now->node, s->devices.infos[i].node) == 0)
            snprintf(id, sizeof id, "gpu:%d", i);
    return row(now, now ? id : "cpu", s->params.threads);
}

json_t *session_devices_json(const struct session *s)
{
    json_t *list = json_array();
    char id[32];
    json_array_append_new(list, row(NULL, "cpu", s->params.threads));
    for (int i = 0; i < s->devices.count; i++) {
        snprintf(id, sizeof id, "gpu:%d", i);
        if (s->devices.infos[i].usable)
            json_array_append_new(list, row(&s->devices.infos[i], id, s->params.threads));
    }
    return list;
}

void session_tell_devices(struct session *s)
{
    session_tell(
        s, 0, json_pack("{s:s, s:o, s:o}", "event", "devices", "device", session_device_json(s), "devices", session_devices_json(s)), NULL);
}

void session_devices_list(struct session *s)
{
    struct pel_device_info infos[SESSION_MOST_DEVICES];
    if (!s->params.list_devices || atomic_exchange(&s->devices.listed, true))
        return;
    int count = pel_device_list(infos, SESSION_MOST_DEVICES, NULL);
    pthread_mutex_lock(&s->lock);
    s->devices.count = count < SESSION_MOST_DEVICES ? count : SESSION_MOST_DEVICES;
    memcpy(s->devices.infos, infos, (size_t)s->devices.count * sizeof *infos);
    session_tell_devices(s);
    pthread_mutex_unlock(&s->lock);
}

bool run_device(struct call *call)
{
    const char *id = call_text(call, "device", 16);
    char *end = NULL;
    long index = id && strncmp(id, "gpu:", 4) == 0 && id[4] >= '0' && id[4] <= '9' ? strtol(id + 4, &end, 10) : -1;
    bool cpu = id && strcmp(id, "cpu") == 0;
    if (!id)
        return false;
    if (!cpu && strcmp(id, "gpu") != 0 && (!end || *end || index > 1000))
        return session_fail(call->error, PEL_ERROR_ARGUMENT, "device: it must be cpu, gpu or gpu:N, as the event devices lists them");
    struct session *s = call->session;
    s->wish = (struct session_wish) { true, cpu, s->wish.number + 1, (int)index, call->client->number, call->has_id, call->id };
    session_interrupt(s);
    return true;
}

/* Makes what was wished for; without the lock. */
static bool make(const struct session *s, const struct session_wish *wish, struct pel_renderer_params *params,
                 struct pel_renderer **renderer, struct pel_error *error)
{
    struct pel_device_params limits = PEL_DEVICE_PARAMS_INIT;
    limits.memory_limit = s->params.gpu_memory;
    params->device = wish->cpu ? NULL : pel_device_create(wish->index, &limits, error);
    *renderer = wish->cpu || params->device ? pel_renderer_create(params, error) : NULL;
    if (!*renderer)
        pel_device_destroy(params->device);
    return *renderer;
}

bool session_device_change(struct session *s, struct pel_renderer **renderer, struct pel_renderer_params params)
{
    const struct session_wish wish = s->wish;
    const struct call call = { .name = "device", .has_id = wish.has_id, .id = wish.id };
    struct pel_error error = PEL_ERROR_INIT;
    struct pel_renderer *made = NULL;
    pthread_mutex_unlock(&s->lock);
    bool fine = make(s, &wish, &params, &made, &error);
    pthread_mutex_lock(&s->lock);
    s->wish.there = s->wish.number != wish.number; /* another came meanwhile */
    bool taken = fine && pel_technique_check(&s->scene, !wish.cpu, &error);
    if (taken) {
        struct pel_renderer *old = *renderer;
        struct pel_device *old_device = s->device;
        *renderer = made;
        made = old;
        s->device = params.device;
        params.device = old_device;
        session_changed(s, false);
        session_tell_devices(s);
    } else {
        struct pel_error told;
        session_fail(&told, error.code, "device: %.500s", error.message);
        session_tell_error(s, wish.client, &told, &call);
    }
    pthread_mutex_unlock(&s->lock);
    if (fine) { /* what is not used: the old ones, or the new */
        pel_renderer_destroy(made);
        pel_device_destroy(params.device);
    }
    pthread_mutex_lock(&s->lock);
    return taken;
}
