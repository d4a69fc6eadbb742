/* SPDX-License-Identifier: MIT */
/* Text and binary numbers out of one stream; see text.h. */
#include "text.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "fail.h"

bool pel_text_init(struct pel_text *text, struct pel_stream *stream, struct pel_error *error)
{
    text->stream = stream;
    text->error = error;
    text->failed = false;
    text->at = text->size = 0;
    text->locale = newlocale(LC_ALL_MASK, "C", (locale_t)0);
    return text->locale != (locale_t)0 || pel_fail(error, PEL_ERROR_MEMORY, "no memory for a locale");
}

void pel_text_finish(struct pel_text *text)
{
    if (text->locale != (locale_t)0)
        freelocale(text->locale);
    text->locale = (locale_t)0;
}

bool pel_text_fill(struct pel_text *text)
{
    if (text->failed)
        return false;
    text->at = text->size = 0;
    if (!pel_stream_read(text->stream, text->bytes, sizeof text->bytes, &text->size, text->error)) {
        text->failed = true;
        text->size = 0;
    }
    return text->size > 0;
}

uint64_t pel_text_tell(const struct pel_text *text)
{
    return pel_stream_tell(text->stream) - (text->size - text->at);
}

uint64_t pel_text_left(const struct pel_text *text)
{
    uint64_t left = pel_stream_bound(text->stream), held = text->size - text->at;
    return left > UINT64_MAX - held ? UINT64_MAX : left + held;
}

static bool is_space(int c)
{
    return c == ' ' || (c >= '\t' && c <= '\r');
}

bool pel_text_line(struct pel_text *text, char *out, size_t size)
{
    size_t length = 0;
    int c = pel_text_get(text);
    if (c < 0)
        return false;
    for (; c >= 0 && c != '\n'; c = pel_text_get(text))
        if (length + 1 < size)
            out[length++] = (char)c;
    while (length && out[length - 1] == '\r')
        length--;
    out[length] = '\0';
    return true;
}

bool pel_text_word(struct pel_text *text, char *out, size_t size)
{
    size_t length = 0;
    int c = pel_text_peek(text);
    for (; c >= 0 && is_space(c); c = pel_text_peek(text))
        text->at++;
    for (; c >= 0 && c != '<' && !is_space(c); c = pel_text_peek(text)) {
        if (length + 1 >= size)
            return false;
        out[length++] = (char)c;
        text->at++;
    }
    out[length] = '\0';
    return length > 0;
}

bool pel_text_starts(struct pel_text *text, const char *word)
{
    size_t wanted = strlen(word), held = text->size - text->at, got = 0;
    if (held < wanted && !text->failed) {
        memmove(text->bytes, text->bytes + text->at, held);
        text->failed = !pel_stream_read(text->stream, text->bytes + held, sizeof text->bytes - held, &got, text->error);
        text->at = 0;
        text->size = text->failed ? 0 : held + got;
    }
    return text->size - text->at >= wanted && !strncasecmp((const char *)text->bytes + text->at, word, wanted);
}

static bool ends_early(struct pel_text *text, uint64_t missing)
{
    if (text->failed)
        return false;
    return pel_fail(text->error, PEL_ERROR_FORMAT, "the file ends %llu bytes too soon", (unsigned long long)missing);
}

bool pel_text_bytes(struct pel_text *text, void *out, size_t size)
{
    size_t held = text->size - text->at, got;
    if (held > size)
        held = size;
    memcpy(out, text->bytes + text->at, held);
    text->at += held;
    if (held == size)
        return true;
    if (text->failed || !pel_stream_read(text->stream, (char *)out + held, size - held, &got, text->error)) {
        text->failed = true;
        return false;
    }
    return got == size - held || ends_early(text, size - held - got);
}

bool pel_text_skip(struct pel_text *text, uint64_t size)
{
    size_t held = text->size - text->at;
    if (size <= held) {
        text->at += (size_t)size;
        return true;
    }
    text->at = text->size;
    size -= held;
    if (size > pel_stream_bound(text->stream))
        return ends_early(text, size - pel_stream_bound(text->stream));
    if (text->failed || !pel_stream_skip(text->stream, size, text->error)) {
        text->failed = true;
        return false;
    }
    return true;
}

bool pel_text_number(const struct pel_text *text, const char *word, double *value)
{
    char *end;
    *value = strtod_l(word, &end, text->locale);
    return end != word && *end == '\0';
}

bool pel_text_list(const struct pel_text *text, const char *string, int count, double *values)
{
    for (int i = 0; i < count; i++) {
        char *end;
        values[i] = strtod_l(string, &end, text->locale);
        if (end == string)
            return false;
        string = end;
    }
    while (is_space((unsigned char)*string))
        string++;
    return *string == '\0';
}

/* Stores a number; false where an integer type cannot hold it. */
static bool store(enum pel_type type, double value, void *out, size_t i)
{
    static const double least[] = { 0, -128, 0, -32768, 0, -2147483648.0 };
    static const double greatest[] = { 255, 127, 65535, 32767, 4294967295.0, 2147483647.0 };
    if (type < PEL_F32 && !(value >= least[type] && value <= greatest[type]))
        return false;
    switch (type) {
    case PEL_U8:
        ((uint8_t *)out)[i] = (uint8_t)value;
        break;
    case PEL_I8:
        ((int8_t *)out)[i] = (int8_t)value;
        break;
    case PEL_U16:
        ((uint16_t *)out)[i] = (uint16_t)value;
        break;
    case PEL_I16:
        ((int16_t *)out)[i] = (int16_t)value;
        break;
    case PEL_U32:
        ((uint32_t *)out)[i] = (uint32_t)value;
        break;
    case PEL_I32:
        ((int32_t *)out)[i] = (int32_t)value;
        break;
    case PEL_F32:
        ((float *)out)[i] = (float)value;
        break;
    default:
        ((double *)out)[i] = value;
        break;
    }
    return true;
}

bool pel_text_numbers(struct pel_text *text, enum pel_type type, size_t count, void *out)
{
    char word[64], *end;
    for (size_t i = 0; i < count; i++) {
        if (!pel_text_word(text, word, sizeof word)) {
            if (text->failed)
                return false;
            return pel_fail(text->error, PEL_ERROR_FORMAT,
                            *word && pel_text_peek(text) >= 0 ? "number %zu of %zu is no number" : "there are only %zu of %zu numbers", i,
                            count);
        }
        if (!out)
            continue;
        /* A float is read as one: rounding to double first would now and then end one step beside it. */
        double value = 0;
        if (type == PEL_F32)
            ((float *)out)[i] = strtof_l(word, &end, text->locale);
        else
            value = strtod_l(word, &end, text->locale);
        if (end == word || *end)
            return pel_fail(text->error, PEL_ERROR_FORMAT, "number %zu of %zu is no number: '%.20s'", i + 1, count, word);
        if (type != PEL_F32 && !store(type, value, out, i))
            return pel_fail(text->error, PEL_ERROR_FORMAT, "number %zu of %zu, %s, does not fit its type %s", i + 1, count, word,
                            pel_type_name(type));
    }
    return true;
}
