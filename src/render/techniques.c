/* SPDX-License-Identifier: MIT */
/* The techniques, a line each, in the order in which they are listed to people. */
#include <string.h>

#include "technique.h"

extern const struct pel_technique pel_technique_raycast, pel_technique_reference, pel_technique_slices2d, pel_technique_slices3d,
    pel_technique_mesh, pel_technique_peel, pel_technique_auto;

const struct pel_technique *const pel_techniques[] = {
    &pel_technique_raycast,
    &pel_technique_auto,
    &pel_technique_slices2d,
    &pel_technique_slices3d,
    &pel_technique_mesh,
    &pel_technique_peel,
    &pel_technique_reference,
    NULL,
};

const struct pel_technique_info *pel_technique_at(size_t index)
{
    size_t count = sizeof pel_techniques / sizeof *pel_techniques - 1;
    return index < count ? &pel_techniques[index]->info : NULL;
}

const struct pel_technique_info *pel_technique_find(const char *name)
{
    for (size_t i = 0; pel_techniques[i]; i++)
        if (!strcmp(pel_techniques[i]->info.name, name))
            return &pel_techniques[i]->info;
    return NULL;
}
