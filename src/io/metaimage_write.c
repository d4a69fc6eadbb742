/* SPDX-License-Identifier: MIT */
/* MetaImage out. Its world is LPS by convention, so a RAS volume is written with its world turned about z; the samples stay as they are. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "alloc.h"
#include "fail.h"
#include "metaimage.h"

static const char *element_type(enum pel_type type)
{
    static const char *const names[] = {
        [PEL_U8] = "MET_UCHAR", [PEL_I8] = "MET_CHAR", [PEL_U16] = "MET_USHORT", [PEL_I16] = "MET_SHORT",
        [PEL_U32] = "MET_UINT", [PEL_I32] = "MET_INT", [PEL_F32] = "MET_FLOAT",  [PEL_F64] = "MET_DOUBLE"
    };
    return names[type];
}

/* The letters of the sides that the axes come from, as ITK says it: RAI is the identity in LPS. Each world axis is given to the index axis
 * that is nearest to it among those that are left. */
static void orientation(const struct pel_volume *volume, char letters[4])
{
    static const char from[2][4] = { "RAI", "LPS" };
    bool used_axis[3] = { false }, used_world[3] = { false };
    for (int n = 0; n < 3; n++) {
        int axis = -1, world = -1;
        double most = -1;
        for (int a = 0; a < 3; a++)
            for (int w = 0; w < 3; w++)
                if (!used_axis[a] && !used_world[w] && fabs(volume->direction[a][w]) > most) {
                    most = fabs(volume->direction[a][w]);
                    axis = a;
                    world = w;
                }
        used_axis[axis] = used_world[world] = true;
        letters[axis] = from[volume->direction[axis][world] < 0][world];
    }
    letters[3] = 0;
}

static bool write_header(struct pel_safe_file *out, const struct pel_volume *given, bool compress, const char *data_file,
                         struct pel_error *error)
{
    struct pel_volume volume = *given; /* placement only; the samples stay borrowed */
    if (volume.space == PEL_SPACE_RAS)
        pel_volume_to_space(&volume, PEL_SPACE_LPS);
    FILE *f = out->file;
    fprintf(f, "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = %s\nCompressedData = %s\n",
            PEL_HOST_BIG_ENDIAN ? "True" : "False", compress ? "True" : "False");
    if (volume.name[0])
        fprintf(f, "Name = %s\n", volume.name);
    fprintf(f, "TransformMatrix =");
    for (int a = 0; a < 3; a++)
        for (int i = 0; i < 3; i++)
            fprintf(f, " %.17g", volume.direction[a][i]);
    fprintf(f, "\nOffset = %.17g %.17g %.17g\nCenterOfRotation = 0 0 0\n", volume.origin[0], volume.origin[1], volume.origin[2]);
    if (volume.space == PEL_SPACE_LPS) {
        char letters[4];
        orientation(&volume, letters);
        fprintf(f, "AnatomicalOrientation = %s\n", letters);
    }
    fprintf(f, "ElementSpacing = %.17g %.17g %.17g\nDimSize = %zu %zu %zu\n", volume.spacing[0], volume.spacing[1], volume.spacing[2],
            volume.dims[0], volume.dims[1], volume.dims[2]);
    if (volume.units[0])
        fprintf(f, "DistanceUnits = %s\n", volume.units);
    if (volume.has_void)
        fprintf(f, "VoidValue = %.17g\n", volume.void_value);
    if (volume.components > 1)
        fprintf(f, "ElementNumberOfChannels = %d\n", volume.components);
    if (fprintf(f, "ElementType = %s\nElementDataFile = %s\n", element_type(volume.type), data_file) < 0 || ferror(f))
        return pel_fail_errno(error, "writing failed");
    return true;
}

static bool write_samples(struct pel_safe_file *out, const struct pel_volume *volume, const struct pel_write_params *params,
                          struct pel_error *error)
{
    return params->compress ? pel_write_samples_deflated(out, volume, false, &params->progress, error)
                            : pel_write_samples(out, volume, &params->progress, error);
}

/* The name of the data file: the header's with another ending. Owned by the caller. */
static char *data_name(const char *path, bool compress, struct pel_error *error)
{
    const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path, *dot = strrchr(name, '.');
    size_t stem = dot ? (size_t)(dot - name) : strlen(name), size = stem + 16;
    char *data = pel_alloc(size, 1, "file name", error);
    if (data)
        snprintf(data, size, "%.*s%s", (int)stem, name, compress ? ".zraw" : ".raw");
    return data;
}

static bool write_detached(const char *path, const struct pel_volume *volume, const struct pel_write_params *params,
                           struct pel_error *error)
{
    struct pel_safe_file header = { 0 }, data = { 0 };
    char *name = data_name(path, params->compress, error), *beside = name ? pel_path_beside(path, name, error) : NULL;
    bool ok = beside && pel_safe_file_open(&header, path, error) && pel_safe_file_open_data(&data, path, beside, name, error) &&
              write_header(&header, volume, params->compress, name, error) && write_samples(&data, volume, params, error) &&
              pel_safe_file_commit(&data, error) && pel_safe_file_commit(&header, error);
    pel_safe_file_abort(&data);
    pel_safe_file_abort(&header);
    free(beside);
    free(name);
    return ok;
}

bool pel_write_metaimage(const char *path, const struct pel_volume *volume, const struct pel_write_params *params, struct pel_error *error)
{
    if (pel_path_has_ending(path, ".mhd"))
        return write_detached(path, volume, params, error);
    struct pel_safe_file out;
    if (!pel_safe_file_open(&out, path, error))
        return false;
    bool ok = write_header(&out, volume, params->compress, "LOCAL", error) && write_samples(&out, volume, params, error) &&
              pel_safe_file_commit(&out, error);
    pel_safe_file_abort(&out);
    return ok;
}
