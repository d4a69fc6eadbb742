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

bool run_probe(struct call *call)
{
    double opacity = 0.1;
    struct pel_pick pick;
    if ((call_has(call, "opacity") && !call_number(call, "opacity", 1e-6, 1, &opacity)) || !session_pick(call, opacity, &pick))
        return false;
    json_t *event = json_pack("{s:s, s:b, s:b, s:O}", "event", "probe", "hit", (int)pick.hit, "inside", (int)pick.inside, "at",
                              json_object_get(call->json, "at"));
    if (pick.hit) {
        json_object_set_new(event, "value", isfinite(pick.value) ? json_real(pick.value) : json_null());
        json_object_set_new(event, "index", session_numbers(pick.index, 3));
        json_object_set_new(event, "world", session_numbers(pick.world, 3));
    }
    session_tell(call->session, call->client->number, event, call);
    return true;
}
