/* SPDX-License-Identifier: MIT */
/* The stream below all readers: gzip members wherever they meet the ends of its buffer, and sources that give little at a time. */
#include "support.h"

#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <zlib.h>

#include "stream.h"

enum { BUFFER = 1 << 16, DATA = 3 * BUFFER }; /* BUFFER is what the stream reads at a time */

/* Bytes that do not compress. */
static unsigned char *make_data(void)
{
    unsigned char *data = malloc(DATA);
    assert_non_null(data);
    uint32_t seed = 1;
    for (size_t i = 0; i < DATA; i++) {
        seed = seed * 1664525u + 1013904223u;
        data[i] = (unsigned char)(seed >> 24);
    }
    return data;
}

/* One gzip member, stored, so that its length is known before it is made: `size` grows by the same for equal numbers of blocks. */
static size_t add_member(unsigned char *out, size_t room, const unsigned char *data, size_t size)
{
    z_stream z = { 0 };
    assert_int_equal(deflateInit2(&z, 0, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY), Z_OK);
    z.next_in = (unsigned char *)data;
    z.avail_in = (uInt)size;
    z.next_out = out;
    z.avail_out = (uInt)room;
    assert_int_equal(deflate(&z, Z_FINISH), Z_STREAM_END);
    size_t length = room - z.avail_out;
    deflateEnd(&z);
    return length;
}

static void expect_all(struct pel_stream *stream, const unsigned char *data, size_t size)
{
    struct pel_error error = PEL_ERROR_INIT;
    unsigned char *bytes = malloc(DATA + 1);
    size_t got;
    assert_non_null(bytes);
    if (!pel_stream_read(stream, bytes, DATA + 1, &got, &error))
        fail_msg("%s", error.message);
    assert_int_equal(got, size);
    assert_memory_equal(bytes, data, size);
    free(bytes);
}

/* The first member ends 0 to 8 bytes before the buffer does, so that the next one's header is cut there in every way. */
static void members_across_the_buffer(void **state)
{
    (void)state;
    unsigned char *data = make_data(), *file = malloc(2 * DATA);
    assert_non_null(file);
    for (size_t before = 0; before <= 8; before++) {
        size_t first = BUFFER - before - 64, size = 0;
        for (; size != BUFFER - before && first < BUFFER; first++)
            size = add_member(file, 2 * DATA, data, first);
        first--;
        assert_int_equal(size, BUFFER - before);
        size_t all = size + add_member(file + size, 2 * DATA - size, data + first, DATA - first);
        for (int behind = 0; behind < 3; behind++) { /* what is behind the last member, whole or cut, is nobody's */
            struct pel_error error = PEL_ERROR_INIT;
            memcpy(file + all, "\x1f\x8b!", 3);
            write_file(scratch("members.gz"), file, all + (size_t)behind);
            struct pel_stream *stream = pel_stream_open(scratch("members.gz"), PEL_STREAM_AUTO, NULL, &error);
            assert_non_null(stream);
            expect_all(stream, data, DATA);
            pel_stream_close(stream);
        }
        /* One member, and 0 to 8 bytes that are no header. */
        memset(file + size, 0x1f, before);
        write_file(scratch("members.gz"), file, size + before);
        struct pel_stream *stream = pel_stream_open(scratch("members.gz"), PEL_STREAM_AUTO, NULL, NULL);
        assert_non_null(stream);
        expect_all(stream, data, first);
        pel_stream_close(stream);
    }
    free(data);
    free(file);
}

/* Opens a pipe that holds `bytes` in packets: each read gives one of them, first all of one byte, then the rest. */
static struct pel_stream *open_drops(const unsigned char *bytes, size_t size, int drops, int *reader, struct pel_error *error)
{
    int ends[2];
    assert_int_equal(pipe2(ends, O_DIRECT), 0);
    size_t done = 0;
    for (int i = 0; i < drops && done < size; i++)
        done += (size_t)write(ends[1], bytes + done, 1);
    if (done < size)
        assert_int_equal(write(ends[1], bytes + done, size - done), size - done);
    char path[64];
    snprintf(path, sizeof path, "/dev/fd/%d", ends[0]);
    *reader = ends[0];
    close(ends[1]);
    return pel_stream_open(path, PEL_STREAM_AUTO, NULL, error);
}

static void little_at_a_time(void **state)
{
    (void)state;
    unsigned char *data = make_data(), file[4096];
    size_t size = add_member(file, sizeof file, data, 500);
    size += add_member(file + size, sizeof file - size, data + 500, 700);
    for (int drops = 0; drops < 8; drops++) {
        for (int gzip = 0; gzip < 2; gzip++) {
            struct pel_error error = PEL_ERROR_INIT;
            int reader;
            struct pel_stream *stream = open_drops(gzip ? file : data, gzip ? size : 1200, drops, &reader, &error);
            if (!stream)
                fail_msg("%s", error.message);
            assert_int_equal(pel_stream_is_compressed(stream), gzip);
            expect_all(stream, data, 1200);
            pel_stream_close(stream);
            close(reader);
        }
    }
    /* A source of fewer bytes than a header has. */
    for (size_t few = 0; few < 4; few++) {
        int reader;
        struct pel_stream *stream = open_drops(file, few, 1, &reader, NULL);
        assert_non_null(stream);
        assert_false(pel_stream_is_compressed(stream));
        expect_all(stream, file, few);
        pel_stream_close(stream);
        close(reader);
    }
    free(data);
}

/* zlib data that end within their first bytes are refused, not taken for whole. */
static void cut_headers(void **state)
{
    (void)state;
    unsigned char *data = make_data(), file[1024];
    size_t size = add_member(file, sizeof file, data, 100);
    for (size_t cut = 0; cut < size - 8; cut++) {
        struct pel_error error = PEL_ERROR_INIT;
        unsigned char out[100];
        write_file(scratch("cut.gz"), file, cut);
        struct pel_stream *stream = pel_stream_open(scratch("cut.gz"), PEL_STREAM_ZLIB, NULL, &error);
        assert_non_null(stream);
        assert_false(pel_stream_read_exact(stream, out, sizeof out, &error));
        assert_int_equal(error.code, PEL_ERROR_FORMAT);
        assert_non_null(strstr(error.message, "truncated"));
        pel_stream_close(stream);
    }
    free(data);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(members_across_the_buffer),
        cmocka_unit_test(little_at_a_time),
        cmocka_unit_test(cut_headers),
    };
    return cmocka_run_group_tests_name("stream", tests, make_scratch, remove_scratch);
}
