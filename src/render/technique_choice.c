/* SPDX-License-Identifier: MIT */
/* A technique and its options as text, for scene files: io knows no techniques, so that what a file says of them is checked here. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "alloc.h"
#include "fail.h"
#include "technique.h"

static bool refuse_name(const char *name, struct pel_error *error)
{
    const struct pel_technique_info *info;
    char known[256] = "";
    for (size_t i = 0; (info = pel_technique_at(i)); i++)
        snprintf(known + strlen(known), sizeof known - strlen(known), "%s%s", i ? ", " : "", info->name);
    return pel_fail(error, PEL_ERROR_ARGUMENT, "technique.name: there is no %s; there are: %s", name, known);
}

static bool set(const struct pel_technique_info *info, const struct pel_technique_choice *choice, void *options, struct pel_error *error)
{
    for (int i = 0; i < choice->option_count; i++) {
        const struct pel_option *row = pel_option_find(info->options, choice->options[i].name);
        if (!row)
            return pel_fail(error, PEL_ERROR_ARGUMENT, "technique.options.%s: %s has no such option", choice->options[i].name, info->name);
        if (!pel_option_set(row, options, choice->options[i].value, error))
            return pel_fail_in(error, "technique.options.");
    }
    return true;
}

bool pel_renderer_take_technique(struct pel_renderer *renderer, const struct pel_technique_choice *choice, struct pel_error *error)
{
    if (!choice->name[0])
        return true;
    const struct pel_technique_info *info = pel_technique_find(choice->name);
    if (!info)
        return refuse_name(choice->name, error);
    void *options = renderer ? pel_renderer_options(renderer, info->name) : NULL;
    void *changed = pel_alloc(1, info->options_size ? info->options_size : 1, "options", error);
    if (!changed)
        return false;
    if (options)
        memcpy(changed, options, info->options_size);
    bool ok = set(info, choice, changed, error);
    if (ok && options)
        memcpy(options, changed, info->options_size);
    free(changed);
    return ok;
}

bool pel_technique_check(const struct pel_scene *scene, bool gpu, struct pel_error *error)
{
    const struct pel_technique *const *t = pel_techniques;
    if (!scene->technique.name[0])
        return true; /* ray casting draws all */
    while (*t && strcmp((*t)->info.name, scene->technique.name) != 0)
        t++;
    if (!*t)
        return refuse_name(scene->technique.name, error);
    const struct pel_technique_info *info = &(*t)->info;
    gpu &= (info->engines & PEL_ENGINE_GPU) != 0;
    if (!gpu && !(info->engines & PEL_ENGINE_CPU))
        return pel_fail(error, PEL_ERROR_UNSUPPORTED,
                        "technique.name: %s draws on a GPU alone, not on the CPU; choose a GPU, or another technique", info->name);
    void *options = pel_alloc(1, info->options_size ? info->options_size : 1, "options", error);
    if (!options)
        return false;
    pel_option_defaults(info->options, options);
    bool ok = set(info, &scene->technique, options, error) && (!(*t)->check || (*t)->check(scene, options, gpu, error));
    free(options);
    return ok;
}

void pel_technique_tell(const struct pel_technique_info *technique, const void *options, struct pel_technique_choice *choice)
{
    memset(choice, 0, sizeof *choice);
    snprintf(choice->name, sizeof choice->name, "%s", technique->name);
    for (const struct pel_option *row = technique->options; row->name && choice->option_count < PEL_MAX_TECHNIQUE_OPTIONS; row++) {
        int i = choice->option_count++;
        snprintf(choice->options[i].name, sizeof choice->options[i].name, "%s", row->name);
        pel_option_get(row, options, choice->options[i].value, sizeof choice->options[i].value);
    }
}
