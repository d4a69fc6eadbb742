/* SPDX-License-Identifier: MIT */
/* NIfTI-1 and -2, one file or two, and ANALYZE 7.5. The field's library turns a header into what it means (byte order, quaternions, units);
 * it is given only headers that were checked before, as it prints what it refuses. The samples we read ourselves: the library allocates
 * what a header asks for whatever the file's length, and turns every NaN into 0, which would make the voids of a volume into values. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include <nifti/nifti2_io.h>

#include "alloc.h"
#include "fail.h"
#include "sample_layout.h"
#include "vec.h"

union header {
    nifti_1_header n1;
    nifti_2_header n2;
    int sizeof_hdr;
    unsigned char bytes[sizeof(nifti_2_header)];
};

struct parsed {
    nifti_image *nim; /* owned */
    bool big_endian;
    bool two_files;
    const char *kind; /* "NIfTI-1", ... */
};

static int magic_version(const unsigned char *magic)
{
    return magic[0] == 'n' && (magic[1] == '+' || magic[1] == 'i') && magic[3] == 0 ? magic[2] - '0' : 0;
}

/* 1 or 2, 0 for ANALYZE, -1 for none of them; *swapped: the header is in the other byte order. */
static int version_of(const unsigned char *bytes, size_t size, bool *swapped)
{
    uint32_t word;
    if (size < sizeof(nifti_1_header))
        return -1;
    memcpy(&word, bytes, 4);
    *swapped = word == __builtin_bswap32(348) || word == __builtin_bswap32(540);
    if (*swapped)
        word = __builtin_bswap32(word);
    if (word == 540)
        return size >= sizeof(nifti_2_header) && magic_version(bytes + 4) == 2 ? 2 : -1;
    if (word != 348)
        return -1;
    return magic_version(bytes + 344) == 1 ? 1 : 0;
}

static bool probe(const unsigned char *bytes, size_t size, const char *path)
{
    bool swapped;
    int version = version_of(bytes, size, &swapped);
    return version > 0 || (version == 0 && pel_path_has_ending(path, ".hdr .hdr.gz"));
}

/* Refuses what the library would print about, or could not count. Header in host order. */
static bool check_numbers(const int64_t dim[8], double vox_offset, int datatype, struct pel_error *error)
{
    int bytes, swap_size;
    if (dim[0] < 1 || dim[0] > 7)
        return pel_fail(error, PEL_ERROR_FORMAT, "says that it has %lld dimensions; 1 to 7 can be", (long long)dim[0]);
    for (int i = 1; i <= dim[0]; i++)
        if (dim[i] < 0 || (dim[i] == 0 && i <= 3))
            return pel_fail(error, PEL_ERROR_FORMAT, "says that it has %lld samples along axis %d", (long long)dim[i], i - 1);
    if (!(vox_offset >= 0 && vox_offset < 2e9))
        return pel_fail(error, PEL_ERROR_FORMAT, "says that its samples begin at byte %g", vox_offset);
    nifti_datatype_sizes(datatype, &bytes, &swap_size);
    if (bytes == 0 || datatype == DT_UNKNOWN || datatype == DT_BINARY)
        return pel_fail(error, PEL_ERROR_FORMAT, "has samples of type code %d, which is not known", datatype);
    return true;
}

static bool parse_header(union header *header, size_t size, struct parsed *parsed, struct pel_error *error)
{
    bool swapped;
    int version = version_of(header->bytes, size, &swapped);
    if (version < 0)
        return pel_fail(error, PEL_ERROR_FORMAT, "has no NIfTI header: it does not begin with the number 348 or 540 in either byte order");
    int64_t dim[8];
    parsed->big_endian = swapped != PEL_HOST_BIG_ENDIAN;
    parsed->kind = version == 0 ? "ANALYZE 7.5" : version == 1 ? "NIfTI-1" : "NIfTI-2";
    if (swapped)
        swap_nifti_header(header, version);
    const char *magic = version == 2 ? header->n2.magic : header->n1.magic;
    parsed->two_files = version == 0 || magic[1] == 'i';
    for (int i = 0; i < 8; i++)
        dim[i] = version == 2 ? header->n2.dim[i] : header->n1.dim[i];
    if (!check_numbers(dim, version == 2 ? (double)header->n2.vox_offset : header->n1.vox_offset,
                       version == 2 ? header->n2.datatype : header->n1.datatype, error))
        return false;
    uint64_t all = 1;
    for (int i = 1; i <= dim[0]; i++)
        if (dim[i] > 0 && __builtin_mul_overflow(all, (uint64_t)dim[i], &all))
            return pel_fail(error, PEL_ERROR_FORMAT, "the product of its sizes is beyond what can be addressed");
    if (all > INT64_MAX / 64)
        return pel_fail(error, PEL_ERROR_FORMAT, "the product of its sizes is beyond what can be addressed");
    parsed->nim = version == 2 ? nifti_convert_n2hdr2nim(header->n2, NULL) : nifti_convert_n1hdr2nim(header->n1, NULL);
    return parsed->nim || pel_fail(error, PEL_ERROR_FORMAT, "its header cannot be understood");
}

/* Type of a number; *numbers is how many of them are one sample of the code. */
static int number_type(int code, uint64_t *numbers)
{
    *numbers = 1;
    switch (code) {
    case DT_UINT8: return PEL_U8;
    case DT_INT8: return PEL_I8;
    case DT_UINT16: return PEL_U16;
    case DT_INT16: return PEL_I16;
    case DT_UINT32: return PEL_U32;
    case DT_INT32: return PEL_I32;
    case DT_INT64: return PEL_FILE_I64;
    case DT_UINT64: return PEL_FILE_U64;
    case DT_FLOAT32: return PEL_F32;
    case DT_FLOAT64: return PEL_F64;
    case DT_RGB24: *numbers = 3; return PEL_U8;
    case DT_RGBA32: *numbers = 4; return PEL_U8;
    case DT_COMPLEX64: *numbers = 2; return PEL_F32;
    case DT_COMPLEX128: *numbers = 2; return PEL_F64;
    default: return -1;
    }
}

static bool lay_out(const struct parsed *parsed, struct pel_layout *layout, struct pel_file_info *info, struct pel_error *error)
{
    const nifti_image *nim = parsed->nim;
    uint64_t numbers;
    *layout = (struct pel_layout){ .component_axis = -1, .type = number_type(nim->datatype, &numbers), .big_endian = parsed->big_endian };
    if (layout->type < 0)
        return pel_fail(error, PEL_ERROR_UNSUPPORTED, "has samples of type %s, which cannot be read", nifti_datatype_string(nim->datatype));
    if (numbers > 1) {
        layout->component_axis = 0;
        layout->sizes[layout->axis_count++] = numbers;
    }
    for (int i = 1; i <= 7; i++) {
        uint64_t size = i <= nim->dim[0] && nim->dim[i] > 0 ? (uint64_t)nim->dim[i] : 1;
        /* Axis 5 is NIfTI's own axis of components, behind time. */
        if (i == 5 && size > 1 && size <= 4 && numbers == 1)
            layout->component_axis = layout->axis_count;
        else if (i > 3 && size > 1)
            pel_info_note(info, i == 4 ? "has %llu time points; the first is taken" : "has %llu volumes; the first is taken",
                          (unsigned long long)size);
        if (i <= 3)
            layout->axes[i - 1] = layout->axis_count;
        layout->sizes[layout->axis_count++] = size;
    }
    bool identity = nim->scl_slope == 0 || (nim->scl_slope == 1 && nim->scl_inter == 0);
    if (!identity && numbers == 1) {
        layout->scaled = true;
        layout->slope = nim->scl_slope;
        layout->intercept = nim->scl_inter;
    }
    pel_layout_note(layout, info);
    return true;
}

static bool usable(const nifti_dmat44 *m)
{
    double rows[3][3], inverse[3][3];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 4; j++) {
            if (!isfinite(m->m[i][j]))
                return false;
            if (j < 3)
                rows[i][j] = m->m[i][j];
        }
    double det = pel_invert3((const double(*)[3])rows, inverse);
    return det != 0 && isfinite(det);
}

static void place(const nifti_image *nim, struct pel_volume *volume, struct pel_file_info *info)
{
    static const char *const units[] = { "", "m", "mm", "um" };
    const nifti_dmat44 *matrix = NULL;
    if (nim->sform_code > 0 && usable(&nim->sto_xyz))
        matrix = &nim->sto_xyz;
    else if (nim->qform_code > 0 && usable(&nim->qto_xyz))
        matrix = &nim->qto_xyz;
    if (!matrix && (nim->sform_code > 0 || nim->qform_code > 0))
        pel_info_note(info, "its transform to the world cannot be inverted; only its spacing is used");
    for (int a = 0; a < 3; a++) {
        double step[3] = { 0, 0, 0 };
        if (matrix)
            for (int i = 0; i < 3; i++)
                step[i] = matrix->m[i][a];
        else
            step[a] = fabs(nim->pixdim[a + 1]);
        pel_volume_set_axis(volume, a, step, info);
        volume->origin[a] = matrix ? matrix->m[a][3] : 0;
    }
    pel_volume_mend_directions(volume, info);
    volume->space = matrix ? PEL_SPACE_RAS : PEL_SPACE_UNKNOWN;
    if (nim->xyz_units >= 0 && nim->xyz_units <= 3)
        pel_copy_text(volume->units, sizeof volume->units, units[nim->xyz_units]);
    pel_copy_text(volume->name, sizeof volume->name, nim->intent_name[0] ? nim->intent_name : nim->descrip);
}

/* The other file of a pair: the name with its ending replaced, gzip'd or not, whichever is there. Owned by the caller. It may be a link to
 * what may not be opened. */
static char *other_file(const char *path, const char *ending, const struct pel_read_params *params, struct pel_error *error)
{
    size_t stem = strlen(path), size = stem + 16;
    if (pel_path_has_ending(path, ".gz"))
        stem -= 3;
    if (stem > 4 && (strncasecmp(path + stem - 4, ".hdr", 4) == 0 || strncasecmp(path + stem - 4, ".img", 4) == 0))
        stem -= 4;
    char *name = pel_alloc(size, 1, "file name", error);
    if (!name)
        return NULL;
    static const char *const gz[] = { "", ".gz" };
    for (int i = 0; i < 2; i++) {
        struct stat st;
        snprintf(name, size, "%.*s%s%s", (int)stem, path, ending, gz[i]);
        if (stat(name, &st) != 0)
            continue;
        if (!params->may_open || params->may_open(params->may_open_user, name))
            return name;
        pel_fail(error, PEL_ERROR_ARGUMENT, "its other file, %.300s, is not among the files that may be opened", name);
        free(name);
        return NULL;
    }
    pel_fail(error, PEL_ERROR_IO, "its other file, %.*s%s, is missing", (int)stem, path, ending);
    free(name);
    return NULL;
}

static bool from_stream(void *user, void *bytes, size_t size, struct pel_error *error)
{
    return pel_stream_read_exact(user, bytes, size, error);
}

static bool read_samples(struct pel_stream *stream, uint64_t offset, const struct pel_layout *layout, struct pel_volume *volume,
                         struct pel_error *error)
{
    uint64_t bytes, at = pel_stream_tell(stream);
    if (!pel_layout_check(layout, &bytes, error))
        return false;
    /* An offset that points into the header can only mean that the samples follow it. */
    uint64_t skip = offset > at ? offset - at : 0;
    return pel_stream_check(stream, skip, "other things before its samples", error) && pel_stream_skip(stream, skip, error) &&
           pel_stream_check(stream, bytes, "samples", error) &&
           pel_layout_read(layout, &(struct pel_sample_source){ from_stream, stream }, volume, error);
}

static bool read_header(struct pel_stream *stream, struct parsed *parsed, struct pel_error *error)
{
    union header header = { 0 };
    size_t size;
    const unsigned char *ahead;
    if (!pel_stream_peek(stream, sizeof header, &ahead, &size, error))
        return false;
    memcpy(header.bytes, ahead, size);
    if (!parse_header(&header, size, parsed, error))
        return false;
    return pel_stream_skip(stream, strcmp(parsed->kind, "NIfTI-2") == 0 ? sizeof(nifti_2_header) : sizeof(nifti_1_header), error);
}

static bool read_nifti(const char *path, const struct pel_read_params *params, struct pel_volume *volume, struct pel_file_info *info,
                       struct pel_error *error)
{
    struct parsed parsed = { 0 };
    struct pel_layout layout;
    bool image_named = pel_path_has_ending(path, ".img .img.gz");
    char *header_path = image_named ? other_file(path, ".hdr", params, error) : pel_strdup(path, error), *image_path = NULL;
    struct pel_stream *header = header_path ? pel_stream_open(header_path, PEL_STREAM_AUTO, &params->progress, error) : NULL, *image = NULL;
    bool ok = header && read_header(header, &parsed, error) && lay_out(&parsed, &layout, info, error);
    if (ok) {
        place(parsed.nim, volume, info);
        if (parsed.two_files) {
            image_path = other_file(path, ".img", params, error);
            image = image_path ? pel_stream_open(image_path, PEL_STREAM_AUTO, &params->progress, error) : NULL;
        }
        ok = (!parsed.two_files || image) &&
             read_samples(image ? image : header, (uint64_t)parsed.nim->iname_offset, &layout, volume, error);
    }
    if (parsed.nim)
        nifti_image_free(parsed.nim);
    pel_stream_close(image);
    pel_stream_close(header);
    free(header_path);
    free(image_path);
    return ok;
}

const struct pel_format pel_format_nifti = {
    .info = { "nifti", "NIfTI-1, NIfTI-2 and ANALYZE 7.5, one file or .hdr and .img", ".nii .hdr .img", true, false },
    .probe = probe,
    .read = read_nifti,
};
