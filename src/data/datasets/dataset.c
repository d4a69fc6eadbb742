/* SPDX-License-Identifier: MIT */
/* The list of computed data sets. To add one: a file beside this one, and one line here. */
#include <pellucid/dataset.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fail.h"
#include "grid.h"

static const struct pel_dataset *const datasets[] = {
    &pel_dataset_hydrogen,
    &pel_dataset_marschner_lobb,
    &pel_dataset_shepp_logan,
    &pel_dataset_gyroid,
    &pel_dataset_sphere,
    &pel_dataset_shell,
    &pel_dataset_box,
    &pel_dataset_torus,
    &pel_dataset_constant,
    &pel_dataset_tornado,
    &pel_dataset_abc,
    NULL,
};

const struct pel_dataset *pel_dataset_at(size_t index)
{
    return index < sizeof datasets / sizeof *datasets ? datasets[index] : NULL;
}

const struct pel_dataset *pel_dataset_find(const char *name)
{
    for (size_t i = 0; datasets[i]; i++)
        if (strcmp(datasets[i]->name, name) == 0)
            return datasets[i];
    return NULL;
}

void *pel_dataset_create_params(const struct pel_dataset *dataset)
{
    void *params = calloc(1, dataset->params_size);
    if (params)
        pel_option_defaults(dataset->options, params);
    return params;
}

bool pel_dataset_make(const struct pel_dataset *dataset, const void *params, struct pel_volume *volume, struct pel_error *error)
{
    if (!dataset->make(params, volume, error)) {
        pel_volume_finish(volume);
        return pel_fail_in(error, "%s: ", dataset->name);
    }
    snprintf(volume->name, sizeof volume->name, "%s", dataset->name);
    pel_volume_update_range(volume);
    return true;
}
