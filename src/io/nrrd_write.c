/* SPDX-License-Identifier: MIT */
/* NRRD out: Teem writes the header, the samples go behind it or into a file beside it. Placement is written as "space directions", which
 * other programs understand; where direction times spacing would not give back the two to the last bit, a key/value pair of our own says
 * them. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "alloc.h"
#include "fail.h"
#include "nrrd.h"

static int nrrd_type(enum pel_type type)
{
    static const int types[] = {
        [PEL_U8] = nrrdTypeUChar, [PEL_I8] = nrrdTypeChar, [PEL_U16] = nrrdTypeUShort, [PEL_I16] = nrrdTypeShort,
        [PEL_U32] = nrrdTypeUInt, [PEL_I32] = nrrdTypeInt, [PEL_F32] = nrrdTypeFloat,  [PEL_F64] = nrrdTypeDouble
    };
    return types[type];
}

/* Whether a reader that splits each direction vector into length and unit vector gets this placement back exactly. */
static bool placement_survives(const struct pel_volume *volume)
{
    struct pel_volume again;
    pel_volume_init(&again);
    for (int a = 0; a < 3; a++) {
        double step[3];
        for (int i = 0; i < 3; i++)
            step[i] = volume->direction[a][i] * volume->spacing[a];
        pel_volume_set_axis(&again, a, step, NULL);
    }
    return memcmp(again.spacing, volume->spacing, sizeof again.spacing) == 0 &&
           memcmp(again.direction, volume->direction, sizeof again.direction) == 0;
}

static void set_key_values(Nrrd *nrrd, const struct pel_volume *volume)
{
    char text[512];
    if (!placement_survives(volume)) {
        const double *s = volume->spacing, *d = &volume->direction[0][0];
        snprintf(text, sizeof text, "%.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g", s[0], s[1], s[2], d[0], d[1],
                 d[2], d[3], d[4], d[5], d[6], d[7], d[8]);
        nrrdKeyValueAdd(nrrd, "pellucid.placement", text);
    }
    if (volume->has_void) {
        snprintf(text, sizeof text, "%.17g", volume->void_value);
        nrrdKeyValueAdd(nrrd, "pellucid.void", text);
    }
}

/* Describes the volume to Teem, which borrows the samples and changes nothing in them. */
static bool describe(Nrrd *nrrd, const struct pel_volume *volume, int vector_kind, struct pel_error *error)
{
    size_t sizes[4];
    unsigned axis = 0, first = volume->components > 1;
    if (first)
        sizes[axis++] = (size_t)volume->components;
    for (int i = 0; i < 3; i++)
        sizes[axis++] = volume->dims[i];
    int space = volume->space == PEL_SPACE_RAS   ? nrrdSpaceRightAnteriorSuperior
                : volume->space == PEL_SPACE_LPS ? nrrdSpaceLeftPosteriorSuperior
                                                 : nrrdSpaceUnknown;
    if (nrrdWrap_nva(nrrd, volume->data, nrrd_type(volume->type), axis, sizes) ||
        (space != nrrdSpaceUnknown ? nrrdSpaceSet(nrrd, space) : nrrdSpaceDimensionSet(nrrd, 3)))
        return pel_fail_teem(error, PEL_ERROR_IO, "its header cannot be written");
    if (first)
        nrrd->axis[0].kind = vector_kind;
    for (unsigned a = 0; a < 3; a++) {
        nrrd->axis[first + a].kind = nrrdKindDomain;
        nrrd->spaceOrigin[a] = volume->origin[a];
        if (volume->units[0])
            nrrd->spaceUnits[a] = strdup(volume->units);
        for (int i = 0; i < 3; i++)
            nrrd->axis[first + a].spaceDirection[i] = volume->direction[a][i] * volume->spacing[a];
    }
    if (volume->name[0])
        nrrd->content = strdup(volume->name);
    set_key_values(nrrd, volume);
    return true;
}

bool pel_nrrd_write_header(struct pel_safe_file *out, const struct pel_volume *volume, int vector_kind, bool gzip, const char *data_file,
                           struct pel_error *error)
{
    pel_teem_lock();
    Nrrd *nrrd = nrrdNew();
    NrrdIoState *nio = nrrdIoStateNew();
    bool ok = nrrd && nio ? describe(nrrd, volume, vector_kind, error) : pel_fail(error, PEL_ERROR_MEMORY, "no memory for the header");
    if (ok) {
        nio->format = nrrdFormatNRRD;
        nio->encoding = gzip ? nrrdEncodingGzip : nrrdEncodingRaw;
        nio->skipData = 1;
        if (nrrdWrite(out->file, nrrd, nio))
            ok = pel_fail_teem(error, PEL_ERROR_IO, "its header cannot be written");
    }
    if (nrrd)
        nrrdNix(nrrd);
    if (nio)
        nrrdIoStateNix(nio);
    pel_teem_unlock();
    if (ok && data_file) {
        /* In place of the empty line that Teem ended the header with, where the file can go back; a header with both is no less right. */
        if (fseek(out->file, -1, SEEK_CUR) == 0 && fprintf(out->file, "data file: %s\n", data_file) < 0)
            ok = pel_fail_errno(error, "writing failed");
    }
    return ok;
}

/* The name of the data file: the header's with another ending. Owned by the caller. */
static char *data_name(const char *path, bool gzip, struct pel_error *error)
{
    const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path, *dot = strrchr(name, '.');
    size_t stem = dot ? (size_t)(dot - name) : strlen(name), size = stem + 16;
    char *data = pel_alloc(size, 1, "file name", error);
    if (data)
        snprintf(data, size, "%.*s%s", (int)stem, name, gzip ? ".raw.gz" : ".raw");
    return data;
}

static bool write_samples(struct pel_safe_file *out, const struct pel_volume *volume, const struct pel_write_params *params,
                          struct pel_error *error)
{
    return params->compress ? pel_write_samples_deflated(out, volume, true, &params->progress, error)
                            : pel_write_samples(out, volume, &params->progress, error);
}

/* The samples are named first: a header never names data that are not there. */
static bool write_detached(const char *path, const struct pel_volume *volume, int kind, const struct pel_write_params *params,
                           struct pel_error *error)
{
    struct pel_safe_file header = { 0 }, data = { 0 };
    char *name = data_name(path, params->compress, error), *beside = name ? pel_path_beside(path, name, error) : NULL;
    bool ok = beside && pel_safe_file_open(&header, path, error) && pel_safe_file_open_data(&data, path, beside, name, error) &&
              pel_nrrd_write_header(&header, volume, kind, params->compress, name, error) && write_samples(&data, volume, params, error) &&
              pel_safe_file_commit(&data, error) && pel_safe_file_commit(&header, error);
    pel_safe_file_abort(&data);
    pel_safe_file_abort(&header);
    free(beside);
    free(name);
    return ok;
}

bool pel_write_nrrd(const char *path, const struct pel_volume *volume, const struct pel_write_params *params, struct pel_error *error)
{
    static const int kinds[] = { nrrdKindUnknown, nrrdKindUnknown, nrrdKind2Vector, nrrdKindVector, nrrdKind4Vector };
    int kind = kinds[volume->components];
    if (volume->type == PEL_U8 && volume->components >= 3)
        kind = volume->components == 3 ? nrrdKindRGBColor : nrrdKindRGBAColor;
    if (pel_path_has_ending(path, ".nhdr"))
        return write_detached(path, volume, kind, params, error);
    struct pel_safe_file out;
    if (!pel_safe_file_open(&out, path, error))
        return false;
    bool ok = pel_nrrd_write_header(&out, volume, kind, params->compress, NULL, error) && write_samples(&out, volume, params, error) &&
              pel_safe_file_commit(&out, error);
    pel_safe_file_abort(&out);
    return ok;
}
