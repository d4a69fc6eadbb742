/* SPDX-License-Identifier: MIT */
/* Computed data sets: volumes and fields from formulas, of any size, the same on every machine. For tests, demos and measurements. */
#ifndef PELLUCID_DATASET_H
#define PELLUCID_DATASET_H

#include <pellucid/option.h>
#include <pellucid/volume.h>

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

/* One data set: its parameters live in a struct of its own that `options` describes; make them with pel_dataset_create_params. */
struct pel_dataset {
    const char *name;     /* "hydrogen" */
    const char *summary;  /* one line */
    const char *citation; /* where the formula is from, or NULL */
    const struct pel_option *options; /* rows of the parameter struct; every one has "size" (samples along each axis) */
    size_t params_size;
    bool (*make)(const void *params, struct pel_volume *volume, struct pel_error *error); /* use pel_dataset_make */
};

/* The data sets in the order in which they are listed; NULL at the end. */
const struct pel_dataset *pel_dataset_at(size_t index);
const struct pel_dataset *pel_dataset_find(const char *name);

/* A zeroed parameter struct with the table's defaults set; free() it. NULL: out of memory. */
void *pel_dataset_create_params(const struct pel_dataset *dataset);

/* Computes into an initialised, empty volume. Range and name are set. */
bool pel_dataset_make(const struct pel_dataset *dataset, const void *params, struct pel_volume *volume, struct pel_error *error);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif
#endif
