/* SPDX-License-Identifier: MIT */
/* VTK XML ImageData (.vti): the samples. vti_scan.c has told what arrays there are and where; here the chosen one is read in a second,
 * forward walk. The encodings are layers: text or bytes of the file -> base64 -> zlib blocks -> samples, each pulled piece by piece, so
 * that nothing but the volume is as large as the volume. Format: "VTK XML Formats" (docs.vtk.org). */
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#include "alloc.h"
#include "fail.h"
#include "sample_layout.h"
#include "text.h"
#include "vec.h"
#include "vti.h"

/* Bytes of the array's encoded data: the file's, or those that its base64 stands for. */
struct source {
    struct pel_text *text;
    struct pel_error *error;
    bool base64;
    unsigned char held[3]; /* bytes of the last group of four that were not wanted yet */
    int held_at, held_count;
};

static bool probe_vti(const unsigned char *bytes, size_t size, const char *path)
{
    (void)path;
    return memmem(bytes, size, "<VTKFile", 8) != NULL && (bytes[0] == '<' || bytes[0] == 0xef || bytes[0] <= ' ');
}

static int base64_digit(int c)
{
    if (c >= 'A' && c <= 'Z')
        return c - 'A';
    if (c >= 'a' && c <= 'z')
        return c - 'a' + 26;
    if (c >= '0' && c <= '9')
        return c - '0' + 52;
    return c == '+' ? 62 : c == '/' ? 63 : -1;
}

/* Decodes one group of four characters. '=' ends a group but not the data: a block's header and the blocks are encoded one after the other.
 */
static bool decode_group(struct source *s)
{
    uint32_t bits = 0;
    int digits = 0, padding = 0;
    while (digits + padding < 4) {
        int c = pel_text_get(s->text), digit = base64_digit(c);
        if (c < 0 || c == '<')
            return s->text->failed ? false : pel_fail(s->error, PEL_ERROR_FORMAT, "the base64 data end too soon");
        if (c == ' ' || (c >= '\t' && c <= '\r'))
            continue;
        if (c == '=' && digits >= 2)
            padding++;
        else if (digit >= 0 && !padding)
            bits |= (uint32_t)digit << (18 - 6 * digits++);
        else
            return pel_fail(s->error, PEL_ERROR_FORMAT, "byte %llu is not base64", (unsigned long long)pel_text_tell(s->text) - 1);
    }
    for (int i = 0; i < 3; i++)
        s->held[i] = (unsigned char)(bits >> (16 - 8 * i));
    s->held_at = 0;
    s->held_count = digits - 1;
    return true;
}

static bool take(struct source *s, void *out, size_t size)
{
    unsigned char *bytes = out;
    if (!s->base64)
        return pel_text_bytes(s->text, out, size);
    while (size) {
        if (s->held_at == s->held_count && !decode_group(s))
            return false;
        for (; size && s->held_at < s->held_count; size--)
            *bytes++ = s->held[s->held_at++];
    }
    return true;
}

/* An upper bound on the bytes to come. */
static uint64_t left(const struct source *s)
{
    uint64_t bytes = pel_text_left(s->text);
    return s->base64 && bytes != UINT64_MAX ? bytes / 4 * 3 + 3 : bytes;
}

/* One number of a block header. */
static bool take_word(struct source *s, const struct pel_vti_header *h, uint64_t *value)
{
    unsigned char bytes[8];
    if (!take(s, bytes, (size_t)h->word))
        return false;
    *value = 0;
    for (int i = 0; i < h->word; i++)
        *value |= (uint64_t)bytes[i] << 8 * (h->big_endian ? h->word - 1 - i : i);
    return true;
}

/* Sizes of compressed blocks, as a block header gives them. */
struct blocks {
    uint64_t count, size, last; /* bytes of a block and of the last one, unpacked */
    uint64_t *packed;           /* owned; bytes of each block in the file */
};

/* Reads the block header; holds what it says against the bytes that are wanted and those that are there. */
static bool take_blocks(struct source *s, const struct pel_vti_header *h, uint64_t wanted, struct blocks *blocks)
{
    uint64_t total, sum = 0;
    if (!take_word(s, h, &blocks->count) || !take_word(s, h, &blocks->size) || !take_word(s, h, &blocks->last))
        return false;
    if (__builtin_mul_overflow(blocks->count, blocks->size, &total) ||
        (blocks->last && blocks->count && __builtin_add_overflow(total - blocks->size, blocks->last, &total)) || total != wanted ||
        blocks->last > blocks->size)
        return pel_fail(s->error, PEL_ERROR_FORMAT, "%llu blocks of %llu bytes, the last of %llu, are not the %llu bytes of the samples",
                        (unsigned long long)blocks->count, (unsigned long long)blocks->size, (unsigned long long)blocks->last,
                        (unsigned long long)wanted);
    if (blocks->count > left(s) / (uint64_t)h->word)
        return pel_fail(s->error, PEL_ERROR_FORMAT, "%llu blocks cannot be in a file of this length", (unsigned long long)blocks->count);
    blocks->packed = pel_alloc((size_t)blocks->count, sizeof *blocks->packed, "block sizes", s->error);
    if (!blocks->packed)
        return false;
    for (uint64_t i = 0; i < blocks->count; i++) {
        if (!take_word(s, h, &blocks->packed[i]))
            return pel_fail_in(s->error, "block sizes: ");
        if (__builtin_add_overflow(sum, blocks->packed[i], &sum))
            sum = UINT64_MAX;
    }
    /* deflate packs 1032 to 1 at best */
    if (sum > left(s) || wanted / 1032 > sum)
        return pel_fail(s->error, PEL_ERROR_FORMAT, "the blocks claim %llu bytes of the file for %llu of samples; there are %llu",
                        (unsigned long long)sum, (unsigned long long)wanted, (unsigned long long)left(s));
    return true;
}

/* Unpacks one block of `packed` bytes into exactly `size`. */
static bool inflate_block(struct source *s, z_stream *z, uint64_t packed, unsigned char *out, size_t size)
{
    unsigned char in[1 << 14];
    int status = inflateReset(z);
    size_t filled = 0;
    while (status == Z_OK && packed) {
        size_t piece = packed < sizeof in ? (size_t)packed : sizeof in;
        if (!take(s, in, piece))
            return false;
        packed -= piece;
        z->next_in = in;
        z->avail_in = (unsigned)piece;
        while (status == Z_OK && z->avail_in) {
            size_t room = size - filled, offered = room < (1u << 30) ? room : 1u << 30;
            z->next_out = out + filled;
            z->avail_out = (unsigned)offered;
            status = inflate(z, Z_NO_FLUSH);
            filled += offered - z->avail_out;
            if (status == Z_BUF_ERROR && !room)
                return pel_fail(s->error, PEL_ERROR_FORMAT, "there is more in a zlib block than its %zu bytes", size);
        }
    }
    if (status != Z_STREAM_END || filled != size || packed)
        return pel_fail(s->error, PEL_ERROR_FORMAT, "damaged zlib block: %s", z->msg ? z->msg : "its size is not what it says");
    return true;
}

static bool take_compressed(struct source *s, const struct blocks *blocks, unsigned char *out)
{
    z_stream z = { 0 };
    if (inflateInit(&z) != Z_OK)
        return pel_fail(s->error, PEL_ERROR_MEMORY, "no memory for zlib");
    bool ok = true;
    for (uint64_t i = 0; ok && i < blocks->count; i++) {
        uint64_t size = i + 1 == blocks->count && blocks->last ? blocks->last : blocks->size;
        ok = inflate_block(s, &z, blocks->packed[i], out, (size_t)size);
        if (!ok)
            pel_fail_in(s->error, "block %llu of %llu: ", (unsigned long long)i + 1, (unsigned long long)blocks->count);
        out += size;
    }
    inflateEnd(&z);
    return ok;
}

/* The bytes of the samples in front of which the text stands, into a volume that is allocated once they are known to be possible. */
static bool read_binary(struct source *s, const struct pel_vti_header *h, const struct pel_vti_array *array, size_t bytes,
                        const size_t shape[3], struct pel_volume *volume)
{
    enum pel_type type = pel_file_type_in_memory(array->type);
    struct blocks blocks = { 0 };
    uint64_t length = 0;
    bool ok = h->compressed ? take_blocks(s, h, bytes, &blocks) : take_word(s, h, &length);
    if (ok && !h->compressed && length != bytes)
        ok = pel_fail(s->error, PEL_ERROR_FORMAT, "its %llu bytes are not the %zu of the extent", (unsigned long long)length, bytes);
    if (ok && !h->compressed && length > left(s))
        ok = pel_fail(s->error, PEL_ERROR_FORMAT, "%zu bytes of samples cannot be in a file of this length; it is truncated or its header is wrong", bytes);
    ok = ok && pel_volume_allocate(volume, shape, type, array->components, s->error);
    ok = ok && (h->compressed ? take_compressed(s, &blocks, volume->data) : take(s, volume->data, bytes));
    free(blocks.packed);
    if (ok && h->big_endian != PEL_HOST_BIG_ENDIAN)
        pel_swap_bytes(volume->data, bytes / pel_type_size(type), pel_type_size(type));
    return ok && (array->type < PEL_TYPE_COUNT || pel_int64_to_f64(volume->data, bytes / 8, array->type == PEL_FILE_U64, s->error));
}

/* Goes to where the array's data begin. */
static bool seek_array(struct pel_text *text, const struct pel_vti_header *h, const struct pel_vti_array *array, struct pel_error *error)
{
    if (array->format != PEL_VTI_APPENDED)
        return pel_text_skip(text, array->offset);
    if (!h->appended)
        return pel_fail(error, PEL_ERROR_FORMAT, "its data are appended, but there is no AppendedData");
    if (!pel_text_skip(text, h->appended))
        return false;
    int c = pel_text_get(text);
    while (c == ' ' || (c >= '\t' && c <= '\r'))
        c = pel_text_get(text);
    if (c != '_')
        return text->failed ? false : pel_fail(error, PEL_ERROR_FORMAT, "AppendedData does not begin with '_'");
    return pel_text_skip(text, array->offset);
}

static bool read_array(struct pel_text *text, const struct pel_vti_header *h, const struct pel_vti_array *array, struct pel_volume *volume,
                       struct pel_error *error)
{
    struct source source = { .text = text, .error = error };
    enum pel_type type = pel_file_type_in_memory(array->type);
    uint64_t dims[3];
    size_t bytes, shape[3];
    for (int a = 0; a < 3; a++)
        shape[a] = (size_t)(dims[a] = pel_vti_dim(h, array->cells, a));
    if (!pel_volume_size_check(dims, type, (uint64_t)array->components, &bytes, error) || !seek_array(text, h, array, error))
        return false;
    if (array->format != PEL_VTI_ASCII) {
        source.base64 = array->format == PEL_VTI_BINARY || h->base64;
        return read_binary(&source, h, array, bytes, shape, volume);
    }
    size_t count = bytes / pel_type_size(type);
    if (count / 2 > pel_text_left(text))
        return pel_fail(error, PEL_ERROR_FORMAT, "%zu numbers cannot be in a file of this length", count);
    return pel_volume_allocate(volume, shape, type, array->components, error) && pel_text_numbers(text, type, count, volume->data);
}

/* Directions of unit length, which most are, are kept to the bit: a volume that was written and read is the same. */
static void keep_direction(const struct pel_vti_header *h, int axis, struct pel_volume *volume)
{
    const double direction[3] = { h->direction[axis], h->direction[3 + axis], h->direction[6 + axis] };
    if (!(fabs(pel_length(direction) - 1) < 1e-12) || !(h->spacing[axis] > 0 && isfinite(h->spacing[axis])))
        return;
    memcpy(volume->direction[axis], direction, sizeof direction);
    volume->spacing[axis] = h->spacing[axis];
}

static void place(const struct pel_vti_header *h, bool cells, struct pel_volume *volume, struct pel_file_info *info)
{
    for (int i = 0; i < 3; i++)
        volume->origin[i] = h->origin[i];
    for (int a = 0; a < 3; a++) {
        double step[3], first = (double)h->extent[2 * a] + (cells && h->extent[2 * a + 1] > h->extent[2 * a] ? 0.5 : 0);
        for (int i = 0; i < 3; i++) {
            step[i] = h->direction[3 * i + a] * h->spacing[a];
            volume->origin[i] += step[i] * first;
        }
        pel_volume_set_axis(volume, a, step, info);
        keep_direction(h, a, volume);
    }
    pel_volume_mend_directions(volume, info);
    volume->space = !strcmp(h->space, "RAS") ? PEL_SPACE_RAS : !strcmp(h->space, "LPS") ? PEL_SPACE_LPS : PEL_SPACE_UNKNOWN;
    pel_copy_text(volume->units, sizeof volume->units, h->units);
    volume->has_void = h->has_void;
    volume->void_value = h->void_value;
    volume->labels = h->labels;
    if (cells)
        pel_info_note(info, "the file has values of cells, not of points: a sample stands at each cell's centre");
}

/* Reads the array that is wanted from a scanned file. */
static bool read_chosen(const char *path, const struct pel_vti_header *h, const struct pel_read_params *params, struct pel_volume *volume,
                        struct pel_file_info *info, struct pel_error *error)
{
    int best = 0;
    for (int i = 0; i < h->array_count; i++) {
        pel_info_array(info, h->arrays[i].name, pel_file_type_in_memory(h->arrays[i].type), h->arrays[i].components);
        if (h->arrays[i].rank > h->arrays[best].rank)
            best = i;
    }
    int chosen = pel_info_choose(info, params, best, error);
    if (chosen < 0)
        return false;
    const struct pel_vti_array *array = &h->arrays[chosen];
    struct pel_stream *stream = pel_stream_open(path, PEL_STREAM_AUTO, &params->progress, error);
    struct pel_text *text = stream ? pel_alloc(1, sizeof *text, "VTK text", error) : NULL;
    bool ok = text && pel_text_init(text, stream, error);
    if (ok && !(ok = read_array(text, h, array, volume, error)))
        pel_fail_in(error, "array '%s': ", array->name);
    if (text)
        pel_text_finish(text);
    free(text);
    pel_stream_close(stream);
    if (!ok)
        return false;
    place(h, array->cells, volume, info);
    pel_copy_text(volume->name, sizeof volume->name, array->name);
    return true;
}

static bool read_vti(const char *path, const struct pel_read_params *params, struct pel_volume *volume, struct pel_file_info *info,
                     struct pel_error *error)
{
    struct pel_vti_header *header = pel_alloc(1, sizeof *header, "VTK header", error);
    bool ok = header && pel_vti_scan(path, header, info, error) && read_chosen(path, header, params, volume, info, error);
    free(header);
    return ok;
}

const struct pel_format pel_format_vti = {
    .info = { "vti", "VTK XML image data", ".vti", true, true },
    .probe = probe_vti,
    .read = read_vti,
    .write = pel_vti_write,
};
