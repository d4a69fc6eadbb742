/* SPDX-License-Identifier: MIT */
#include <math.h>

#include "session_inside.h"

bool session_pick(struct call *call, double opacity, struct pel_pick *pick)
{
    const struct session *s = call->session;
    double at[2];
    if (!call_numbers(call, "at", 2, at))
        return false;
    for (int i = 0; i < 2; i++)
        if (!(at[i] >= 0 && at[i] <= 1))
            return session_fail(call->error, PEL_ERROR_ARGUMENT, "at: %g is outside the picture, which goes from 0 to 1", at[i]);
    return pel_scene_pick(&s->scene, s->size[0], s->size[1], at[0] * s->size[0], at[1] * s->size[1], opacity, pick, call->error);
}

/* The value between the samples; NaN where one of them is void. Labels are not mixed, of components the magnitude is told. */
static double value_at(const struct pel_volume *volume, const double index[3])
{
    size_t low[3];
    double part[3], sum = 0;
    for (int a = 0; a < 3; a++) {
        double x = fmin(fmax(index[a], 0), (double)(volume->dims[a] - 1));
        x = volume->labels ? round(x) : x;
        low[a] = (size_t)x;
        part[a] = x - (double)low[a];
    }
    for (int corner = 0; corner < 8; corner++) {
        double weight = 1, square = 0, value = 0;
        size_t at[3];
        for (int a = 0; a < 3; a++) {
            weight *= corner >> a & 1 ? part[a] : 1 - part[a];
            at[a] = low[a] + (size_t)(corner >> a & 1);
        }
        if (weight == 0) /* at the last sample there is no next one */
            continue;
        for (int c = 0; c < volume->components; c++) {
            value = pel_volume_get(volume, at[0], at[1], at[2], c);
            if (pel_volume_is_void(volume, value))
                return NAN;
            square += value * value;
        }
        sum += weight * (volume->components > 1 ? sqrt(square) : value);
    }
    return sum;
}

/* What is at a place of the world, seen or not. */
static bool look_up(struct call *call, struct pel_pick *pick)
{
    const struct pel_volume *volume = call->session->scene.volume;
    if (call_has(call, "at"))
        return session_fail(call->error, PEL_ERROR_ARGUMENT, "world: give it or at, not both");
    if (!call_numbers(call, "world", 3, pick->world))
        return false;
    pel_volume_world_to_index(volume, pick->world, pick->index);
    pick->inside = true;
    for (int a = 0; a < 3; a++)
        pick->inside &= pick->index[a] >= -0.5 && pick->index[a] <= (double)volume->dims[a] - 0.5;
    pick->hit = pick->inside;
    if (pick->hit)
        pick->value = value_at(volume, pick->index);
    return true;
}

bool run_probe(struct call *call)
{
    double opacity = 0.1;
    struct pel_pick pick = { .hit = false };
    if (call_has(call, "opacity") && !call_number(call, "opacity", 1e-6, 1, &opacity))
        return false;
    if (call_has(call, "world") ? !look_up(call, &pick) : !session_pick(call, opacity, &pick))
        return false;
    json_t *event = json_pack("{s:s, s:b, s:b, s:O?}", "event", "probe", "hit", (int)pick.hit, "inside", (int)pick.inside, "at",
                              json_object_get(call->json, "at"));
    if (pick.hit) {
        json_object_set_new(event, "value", isfinite(pick.value) ? json_real(pick.value) : json_null());
        json_object_set_new(event, "index", session_numbers(pick.index, 3));
        json_object_set_new(event, "world", session_numbers(pick.world, 3));
    }
    session_tell(call->session, call->client->number, event, call);
    return true;
}
