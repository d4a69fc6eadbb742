/* SPDX-License-Identifier: MIT */
#include "sample_layout.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>

#include "alloc.h"
#include "fail.h"

enum { CHUNK = 1 << 16 }; /* numbers that are scattered at a time */

enum pel_type pel_file_type_in_memory(int file_type)
{
    return file_type >= PEL_TYPE_COUNT ? PEL_F64 : (enum pel_type)file_type;
}

static enum pel_type volume_type(const struct pel_layout *layout)
{
    if (layout->scaled)
        return layout->type == PEL_F32 || pel_type_size(pel_file_type_in_memory(layout->type)) <= 2 ? PEL_F32 : PEL_F64;
    return pel_file_type_in_memory(layout->type);
}

static void shape(const struct pel_layout *layout, uint64_t dims[3], uint64_t *components)
{
    for (int i = 0; i < 3; i++)
        dims[i] = layout->axes[i] < 0 ? 1 : layout->sizes[layout->axes[i]];
    *components = layout->component_axis < 0 ? 1 : layout->sizes[layout->component_axis];
}

bool pel_layout_check(const struct pel_layout *layout, uint64_t *bytes, struct pel_error *error)
{
    uint64_t dims[3], components;
    size_t volume_bytes, all = pel_type_size(pel_file_type_in_memory(layout->type));
    shape(layout, dims, &components);
    if (!pel_volume_size_check(dims, volume_type(layout), components, &volume_bytes, error))
        return false;
    for (int i = 0; i < layout->axis_count; i++) {
        if (layout->sizes[i] == 0)
            return pel_fail(error, PEL_ERROR_FORMAT, "has no samples along axis %d", i);
        if (layout->sizes[i] > PTRDIFF_MAX || !pel_mul(all, (size_t)layout->sizes[i], &all) || all > PTRDIFF_MAX)
            return pel_fail(error, PEL_ERROR_FORMAT, "the product of its sizes is beyond what can be addressed");
    }
    *bytes = all;
    return true;
}

void pel_layout_note(const struct pel_layout *layout, struct pel_file_info *info)
{
    if (layout->type >= PEL_TYPE_COUNT)
        pel_info_note(info, "64-bit integers are held as f64, which has the same values up to 2^53");
    if (layout->scaled)
        pel_info_note(info, "values are scaled by %g and shifted by %g, as the header says", layout->slope, layout->intercept);
}

/* True where the volume's numbers are the first ones of the file, in the volume's own order. */
static bool is_prefix(const struct pel_layout *layout)
{
    int wanted[4] = { layout->component_axis, layout->axes[0], layout->axes[1], layout->axes[2] }, at = 0;
    bool extra = false;
    for (int axis = 0; axis < layout->axis_count; axis++) {
        if (layout->sizes[axis] == 1)
            continue;
        int place = -1;
        for (int w = 0; w < 4; w++)
            if (wanted[w] == axis)
                place = w;
        if (place >= 0 && (extra || place < at))
            return false;
        if (place >= 0)
            at = place;
        else
            extra = true;
    }
    return true;
}

static void to_host(const struct pel_layout *layout, void *numbers, size_t count)
{
    if (layout->big_endian != PEL_HOST_BIG_ENDIAN)
        pel_swap_bytes(numbers, count, pel_type_size(pel_file_type_in_memory(layout->type)));
}

static bool finish_chunk(const struct pel_layout *layout, void *numbers, size_t count, struct pel_error *error)
{
    to_host(layout, numbers, count);
    return layout->type < PEL_TYPE_COUNT || pel_int64_to_f64(numbers, count, layout->type == PEL_FILE_U64, error);
}

static double number_at(enum pel_type type, const void *numbers, size_t i)
{
    switch (type) {
    case PEL_U8: return ((const uint8_t *)numbers)[i];
    case PEL_I8: return ((const int8_t *)numbers)[i];
    case PEL_U16: return ((const uint16_t *)numbers)[i];
    case PEL_I16: return ((const int16_t *)numbers)[i];
    case PEL_U32: return ((const uint32_t *)numbers)[i];
    case PEL_I32: return ((const int32_t *)numbers)[i];
    case PEL_F32: return ((const float *)numbers)[i];
    default: return ((const double *)numbers)[i];
    }
}

/* Puts `count` numbers of a chunk at their places, `stride` numbers apart. */
static void scatter(const struct pel_layout *layout, enum pel_type to, void *out, const unsigned char *in, size_t count, size_t stride)
{
    enum pel_type from = pel_file_type_in_memory(layout->type);
    size_t size = pel_type_size(to);
    if (layout->scaled && to == PEL_F32)
        for (size_t i = 0; i < count; i++)
            ((float *)out)[i * stride] = (float)(number_at(from, in, i) * layout->slope + layout->intercept);
    else if (layout->scaled)
        for (size_t i = 0; i < count; i++)
            ((double *)out)[i * stride] = number_at(from, in, i) * layout->slope + layout->intercept;
    else
        for (size_t i = 0; i < count; i++)
            memcpy((char *)out + i * stride * size, in + i * size, size);
}

/* Reads in file order and puts each number where it belongs, so that no second copy of the volume is needed. */
static bool read_scattered(const struct pel_layout *layout, const struct pel_sample_source *source, struct pel_volume *volume,
                           struct pel_error *error)
{
    size_t size = pel_type_size(pel_file_type_in_memory(layout->type)), out_size = pel_type_size(volume->type);
    size_t strides[8] = { 0 }, stride = 1, left = pel_volume_samples(volume) * (size_t)volume->components;
    bool wanted[8] = { false };
    if (layout->component_axis >= 0) {
        strides[layout->component_axis] = 1;
        wanted[layout->component_axis] = true;
        stride = (size_t)volume->components;
    }
    for (int i = 0; i < 3; i++)
        if (layout->axes[i] >= 0) {
            strides[layout->axes[i]] = stride;
            wanted[layout->axes[i]] = true;
            stride *= volume->dims[i];
        }
    unsigned char *chunk = pel_alloc(CHUNK, 8, "read buffer", error);
    if (!chunk)
        return false;
    uint64_t index[8] = { 0 };
    bool ok = true;
    while (ok && left > 0) {
        size_t base = 0;
        bool take = true;
        for (int a = 1; a < layout->axis_count; a++) {
            base += (size_t)index[a] * strides[a];
            take = take && (wanted[a] || index[a] == 0);
        }
        for (uint64_t done = 0; ok && done < layout->sizes[0];) {
            size_t n = layout->sizes[0] - done < CHUNK ? (size_t)(layout->sizes[0] - done) : CHUNK;
            ok = source->read(source->user, chunk, n * size, error) && finish_chunk(layout, chunk, n, error);
            size_t used = !take ? 0 : wanted[0] ? n : done == 0 ? 1 : 0;
            if (ok && used) {
                scatter(layout, volume->type, (char *)volume->data + (base + (size_t)done * strides[0]) * out_size, chunk, used,
                        strides[0]);
                left -= used;
            }
            done += n;
        }
        for (int a = 1; a < layout->axis_count && ++index[a] == layout->sizes[a]; a++)
            index[a] = 0;
    }
    free(chunk);
    return ok;
}

bool pel_layout_read(const struct pel_layout *layout, const struct pel_sample_source *source, struct pel_volume *volume,
                     struct pel_error *error)
{
    uint64_t dims64[3], components;
    shape(layout, dims64, &components);
    size_t dims[3] = { (size_t)dims64[0], (size_t)dims64[1], (size_t)dims64[2] };
    if (!pel_volume_allocate(volume, dims, volume_type(layout), (int)components, error))
        return false;
    if (!is_prefix(layout) || layout->scaled)
        return read_scattered(layout, source, volume, error);
    size_t count = pel_volume_samples(volume) * (size_t)volume->components;
    return source->read(source->user, volume->data, count * pel_type_size(volume->type), error) &&
           finish_chunk(layout, volume->data, count, error);
}

bool pel_int64_to_f64(void *numbers, size_t count, bool is_unsigned, struct pel_error *error)
{
    for (size_t i = 0; i < count; i++) {
        int64_t v;
        memcpy(&v, (char *)numbers + 8 * i, 8);
        bool fits = is_unsigned ? (uint64_t)v <= (uint64_t)1 << 53 : v <= (int64_t)1 << 53 && v >= -((int64_t)1 << 53);
        if (!fits)
            return pel_fail(error, PEL_ERROR_UNSUPPORTED, "has a 64-bit integer beyond 2^53, which a double cannot hold exactly");
        double d = is_unsigned ? (double)(uint64_t)v : (double)v;
        memcpy((char *)numbers + 8 * i, &d, 8);
    }
    return true;
}

bool pel_text_file_numbers(struct pel_text *text, int file_type, void *numbers, size_t count, struct pel_error *error)
{
    if (file_type < PEL_TYPE_COUNT)
        return pel_text_numbers(text, (enum pel_type)file_type, count, numbers);
    bool is_unsigned = file_type == PEL_FILE_U64;
    for (size_t i = 0; i < count; i++) {
        char word[32], *end;
        bool there = pel_text_word(text, word, sizeof word);
        if (text->failed)
            return false; /* the reason is told already */
        if (!there)
            return pel_fail(error, PEL_ERROR_FORMAT, "has %zu numbers where %zu should be; it is truncated or its header is wrong", i,
                            count);
        long long v = is_unsigned ? (long long)strtoull(word, &end, 10) : strtoll(word, &end, 10);
        if (*end)
            return pel_fail(error, PEL_ERROR_FORMAT, "has something that is no integer among its data (number %zu)", i + 1);
        memcpy((char *)numbers + 8 * i, &v, 8);
    }
    return true;
}

static int hex_value(int c)
{
    return c >= '0' && c <= '9' ? c - '0' : c >= 'a' && c <= 'f' ? c - 'a' + 10 : c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}

bool pel_text_hex(struct pel_text *text, unsigned char *bytes, size_t size, struct pel_error *error)
{
    for (size_t i = 0; i < 2 * size; i++) {
        int c;
        do {
            c = pel_text_get(text);
        } while (c >= 0 && isspace(c));
        if (c < 0 && text->failed)
            return false;
        int v = hex_value(c);
        if (v < 0)
            return pel_fail(error, PEL_ERROR_FORMAT,
                            "has %zu hexadecimal bytes where %zu should be; it is truncated or its header is wrong", i / 2, size);
        bytes[i / 2] = (unsigned char)(i % 2 ? bytes[i / 2] | v : v << 4);
    }
    return true;
}
