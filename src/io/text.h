/* SPDX-License-Identifier: MIT */
/* Text and binary numbers out of one stream: what the VTK formats, which mix words and raw samples in a file, are read with. Numbers are
 * read the same way whatever the program's locale is. */
#ifndef PEL_IO_TEXT_H
#define PEL_IO_TEXT_H

#include <locale.h>
#include <stddef.h>
#include <stdint.h>

#include <pellucid/error.h>
#include <pellucid/volume.h>

#include "stream.h"

struct pel_text {
    struct pel_stream *stream; /* borrowed */
    struct pel_error *error;   /* borrowed, nullable: where a read error goes */
    locale_t locale;           /* the C locale */
    bool failed;               /* a read error was met, and looks like the end of the text since */
    size_t at, size;
    unsigned char bytes[1 << 15];
};

bool pel_text_init(struct pel_text *text, struct pel_stream *stream, struct pel_error *error);
void pel_text_finish(struct pel_text *text); /* accepts a zeroed one; leaves the stream open */

/* For pel_text_get and pel_text_peek: reads more; false at the end. */
bool pel_text_fill(struct pel_text *text);

/* The next byte, taken or not; -1 at the end. */
static inline int pel_text_get(struct pel_text *text)
{
    return text->at < text->size || pel_text_fill(text) ? text->bytes[text->at++] : -1;
}

static inline int pel_text_peek(struct pel_text *text)
{
    return text->at < text->size || pel_text_fill(text) ? text->bytes[text->at] : -1;
}

/* Bytes taken so far, and an upper bound on those to come (see pel_stream_bound). */
uint64_t pel_text_tell(const struct pel_text *text);
uint64_t pel_text_left(const struct pel_text *text);

/* The rest of the line without its end, cut to `size`; false at the end of the text. */
bool pel_text_line(struct pel_text *text, char *out, size_t size);

/* The next word between white space; false where there is none or it is longer than `size` - 1. A '<' ends a word too and is not taken. */
bool pel_text_word(struct pel_text *text, char *out, size_t size);

/* Whether the text goes on with `word`, upper or lower case (at most 64 characters); takes nothing. */
bool pel_text_starts(struct pel_text *text, const char *word);

/* Takes exactly `size` bytes, or skips them. PEL_ERROR_FORMAT where the file ends sooner. */
bool pel_text_bytes(struct pel_text *text, void *out, size_t size);
bool pel_text_skip(struct pel_text *text, uint64_t size);

/* Takes `count` numbers in words and stores them as `type`; refuses what is no number or does not fit. `out` NULL: only skips words. */
bool pel_text_numbers(struct pel_text *text, enum pel_type type, size_t count, void *out);

/* One number from a whole string; false where it is none. NaN and infinity are numbers. */
bool pel_text_number(const struct pel_text *text, const char *word, double *value);

/* `count` numbers from a string with white space between them and nothing after them. */
bool pel_text_list(const struct pel_text *text, const char *string, int count, double *values);

#endif
