/* SPDX-License-Identifier: MIT */
/* VTK XML image data: the facts of real files, every encoding and header, what VTK may leave out, round trips, damage. */
#include "support.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#define PLAIN_AXES "axis 0: 1 0 0\naxis 1: 0 1 0\naxis 2: 0 0 1\n"

static void facts_of_real_files(void **state)
{
    (void)state;
    expect_description(data_path("hydrogen.vti"), "vti 64x64x64 f32 x1\nspacing 1 1 1\norigin 0 0 0\n" PLAIN_AXES
                                                  "space unknown units ''\nmin 0 max 1 mean 0.018524 nonzero 249600 voids 0\n");
    expect_description(data_path("isabel_speed.vti"),
                       "vti 125x125x25 f64 x1\nspacing 4.00803213 4.00803213 4.04081633\norigin 0 0 0\n" PLAIN_AXES
                       "space unknown units ''\nmin 0 max 76.5653 mean 11.842452 nonzero 386478 voids 0\n");
}

static void round_trips(void **state)
{
    (void)state;
    expect_round_trips("a.vti", PEL_SPACE_RAS);
    expect_round_trips("a.vti", PEL_SPACE_LPS);
    expect_round_trips("a.vti", PEL_SPACE_UNKNOWN);
}

/* More than one block, a name that XML must escape, labels. */
static void large_round_trip(void **state)
{
    (void)state;
    struct pel_volume written, read;
    struct pel_write_params params = PEL_WRITE_PARAMS_INIT;
    struct pel_error error = PEL_ERROR_INIT;
    for (int compress = 0; compress < 2; compress++) {
        pel_volume_init(&written);
        assert_true(pel_volume_allocate(&written, (const size_t[3]) { 99, 101, 53 }, PEL_U16, 1, &error));
        for (size_t i = 0; i < pel_volume_samples(&written); i++)
            ((uint16_t *)written.data)[i] = (uint16_t)(i * i / 1000);
        snprintf(written.name, sizeof written.name, "a<b & \"c\" \xc3\xa4");
        written.labels = true;
        pel_volume_update_range(&written);
        params.compress = compress;
        assert_true(pel_write_volume(scratch("l.vti"), &written, &params, &error));
        read_ok(scratch("l.vti"), &read, NULL);
        expect_same(&written, &read);
        assert_true(read.labels);
        pel_volume_finish(&written);
        pel_volume_finish(&read);
    }
}

/* The samples of every small file below: 3 x 2 x 2 numbers, in rising order. */
enum { SAMPLES = 12 };

struct layout {
    bool big_endian, wide, compressed;
    enum { ASCII, INLINE, RAW, BASE64 } encoding;
};

static size_t base64(const unsigned char *in, size_t size, char *out)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    size_t n = 0;
    for (size_t i = 0; i < size; i += 3) {
        unsigned bits = (unsigned)in[i] << 16 | (i + 1 < size ? (unsigned)in[i + 1] << 8 : 0) | (i + 2 < size ? in[i + 2] : 0);
        for (int k = 0; k < 4; k++)
            out[n++] = (size_t)k > size - i ? '=' : digits[bits >> (18 - 6 * k) & 63];
    }
    return n;
}

static size_t put_word(unsigned char *out, const struct layout *layout, uint64_t value)
{
    int size = layout->wide ? 8 : 4;
    for (int i = 0; i < size; i++)
        out[i] = (unsigned char)(value >> 8 * (layout->big_endian ? size - 1 - i : i));
    return (size_t)size;
}

/* Encodes the array of doubles first, first + 1, ... as the layout says; returns the bytes of it. */
static size_t encode(const struct layout *layout, double first, char *out)
{
    unsigned char samples[SAMPLES * 8], header[64], body[512];
    size_t head = 0, size = 0, n = 0;
    for (int i = 0; i < SAMPLES; i++) {
        double value = first + i;
        uint64_t bits;
        memcpy(&bits, &value, 8);
        for (int b = 0; b < 8; b++)
            samples[8 * i + b] = (unsigned char)(bits >> 8 * (layout->big_endian ? 7 - b : b));
        if (layout->encoding == ASCII)
            n += (size_t)sprintf(out + n, "%.17g ", value);
    }
    if (layout->encoding == ASCII)
        return n;
    if (layout->compressed) { /* blocks of 40, 40 and 16 bytes */
        head += put_word(header, layout, 3);
        head += put_word(header + head, layout, 40);
        head += put_word(header + head, layout, 16);
        for (int k = 0; k < 3; k++) {
            uLongf packed = sizeof body - size;
            assert_int_equal(compress2(body + size, &packed, samples + (ptrdiff_t)(40 * k), k < 2 ? 40 : 16, 6), Z_OK);
            head += put_word(header + head, layout, packed);
            size += packed;
        }
    } else {
        head = put_word(header, layout, sizeof samples);
        memcpy(body, samples, size = sizeof samples);
    }
    if (layout->encoding == RAW) {
        memcpy(out, header, head);
        memcpy(out + head, body, size);
        return head + size;
    }
    if (layout->compressed) { /* the header is encoded on its own */
        n = base64(header, head, out);
        return n + base64(body, size, out + n);
    }
    unsigned char both[600];
    memcpy(both, header, head);
    memcpy(both + head, body, size);
    return base64(both, head + size, out);
}

/* A file with two arrays, p and q, which start at 1 and at 101. Returns its size. */
static size_t write_vti(const char *path, const struct layout *layout, const char *extent, const char *point_data)
{
    static const char *const formats[] = { "ascii", "binary", "appended", "appended" };
    char p[2048], q[2048], file[8192];
    size_t np = encode(layout, 1, p), nq = encode(layout, 101, q), n;
    bool appended = layout->encoding == RAW || layout->encoding == BASE64;
    n = (size_t)sprintf(file,
                        "<?xml version='1.0'?>\n<!-- <Piece> -->\n<VTKFile type=\"ImageData\" byte_order=\"%s\"%s%s>\n"
                        "<ImageData WholeExtent=\"%s\" Origin=\"1 2 3\" Spacing=\"1 2 4\">\n<FieldData><DataArray type='Float64' Name='t' "
                        "format='ascii'>1 2</DataArray></FieldData>\n<Piece Extent=\"%s\">\n<PointData %s>\n",
                        layout->big_endian ? "BigEndian" : "LittleEndian", layout->wide ? " header_type=\"UInt64\"" : "",
                        layout->compressed ? " compressor=\"vtkZLibDataCompressor\"" : "", extent, extent, point_data);
    for (int k = 0; k < 2; k++) {
        n += (size_t)sprintf(file + n, "<DataArray type=\"Float64\" Name=\"%c\" format=\"%s\" offset=\"%zu\">\n", "pq"[k],
                             formats[layout->encoding], k ? np : 0);
        if (!appended) {
            const char *key = "<InformationKey name='x' location='y'><Value index='0'>5</Value></InformationKey>\n  ";
            n += (size_t)sprintf(file + n, "  %s", k ? key : "");
            memcpy(file + n, k ? q : p, k ? nq : np);
            n += k ? nq : np;
            n += (size_t)sprintf(file + n, "%s", k ? "" : key);
        }
        n += (size_t)sprintf(file + n, "\n</DataArray>\n");
    }
    n += (size_t)sprintf(file + n, "</PointData><CellData/></Piece></ImageData>\n");
    if (appended) {
        n += (size_t)sprintf(file + n, "<AppendedData encoding=\"%s\">\n_", layout->encoding == RAW ? "raw" : "base64");
        memcpy(file + n, p, np);
        memcpy(file + n + np, q, nq);
        n += np + nq;
        n += (size_t)sprintf(file + n, "\n</AppendedData>");
    }
    n += (size_t)sprintf(file + n, "</VTKFile>\n");
    write_file(path, file, n);
    return n;
}

static void expect_samples(const char *path, const char *array, double first)
{
    struct pel_volume v;
    struct pel_read_params params = PEL_READ_PARAMS_INIT;
    struct pel_error error = PEL_ERROR_INIT;
    params.array = array;
    pel_volume_init(&v);
    if (!pel_read_volume(path, &params, &v, NULL, &error))
        fail_msg("%s", error.message);
    for (size_t i = 0; i < SAMPLES; i++)
        assert_true(((double *)v.data)[i] == first + (double)i);
    pel_volume_finish(&v);
}

static void all_encodings(void **state)
{
    (void)state;
    for (int i = 0; i < 32; i++) {
        struct layout layout = { .big_endian = i & 1, .wide = i & 2, .compressed = i & 4, .encoding = i >> 3 };
        size_t size = write_vti(scratch("e.vti"), &layout, "0 2 0 1 0 1", "Scalars=\"q\"");
        expect_samples(scratch("e.vti"), "p", 1);
        expect_samples(scratch("e.vti"), "q", 101);
        expect_samples(scratch("e.vti"), NULL, 101); /* the active one */
        /* q stands last: nothing of it may be missing, and after it there is only the end of the XML */
        size_t tail = layout.encoding >= RAW ? strlen("\n</AppendedData></VTKFile>\n") : strlen("\n</DataArray>\n");
        if (layout.encoding >= RAW && layout.big_endian == layout.wide)
            expect_truncations_fail(scratch("e.vti"), scratch("cut.vti"), size - tail);
        unsigned char *bytes = read_file(scratch("e.vti"), &size);
        write_gzip(scratch("e.vti.gz"), bytes, size);
        free(bytes);
        expect_samples(scratch("e.vti.gz"), "q", 101);
    }
}

static void places(void **state)
{
    (void)state;
    struct layout layout = { .encoding = ASCII };
    write_vti(scratch("p.vti"), &layout, "-1 1 10 11 5 6", "");
    expect_description(scratch("p.vti"), "vti 3x2x2 f64 x1\nspacing 1 2 4\norigin 0 22 23\n" PLAIN_AXES
                                         "space unknown units ''\nmin 1 max 12 mean 6.500000 nonzero 12 voids 0\n");
    write_text(
        scratch("d.vti"),
        "<VTKFile type='ImageData'><ImageData WholeExtent='2 3 0 1 0 0' Origin='10 0 0' Spacing='1 2 1' Direction='0 -1 0 1 0 0 0 0 1'>"
        "<Piece Extent='2 3 0 1 0 0'><CellData Scalars='c'><DataArray type='Int8' Name='c'>-7</DataArray></CellData>"
        "</Piece></ImageData></VTKFile>");
    expect_description(scratch("d.vti"), "vti 1x1x1 i8 x1\nspacing 1 2 1\norigin 9 2.5 0\naxis 0: 0 1 0\naxis 1: -1 0 0\naxis 2: 0 0 1\n"
                                         "space unknown units ''\nmin -7 max -7 mean -7.000000 nonzero 1 voids 0\n"
                                         "note: the file has values of cells, not of points: a sample stands at each cell's centre\n");
}

/* A file around one array of 2 x 2 x 2 bytes; the attributes of the tags are given. */
static void write_one(const char *file, const char *image, const char *piece, const char *array, const char *content)
{
    char text[4096];
    snprintf(text, sizeof text,
             "<VTKFile %s><ImageData %s><Piece %s><PointData><DataArray %s>%s</DataArray></PointData></Piece></ImageData></VTKFile>", file,
             image, piece, array, content);
    write_text(scratch("one.vti"), text);
}

#define FILE_TAG "type='ImageData' header_type='UInt64'"
#define IMAGE_TAG "WholeExtent='0 1 0 1 0 1'"
#define PIECE_TAG "Extent='0 1 0 1 0 1'"
#define ARRAY_TAG "type='UInt8' Name='a' format='binary'"
#define GOOD "CAAAAAAAAAABAgMEBQYHCA=="

static void expect_refused(const char *file, const char *image, const char *piece, const char *array, const char *content, const char *part)
{
    write_one(file, image, piece, array, content);
    expect_bad(scratch("one.vti"), part);
}

static void bad_tags(void **state)
{
    (void)state;
    struct pel_volume v;
    write_one(FILE_TAG, IMAGE_TAG, PIECE_TAG, ARRAY_TAG, GOOD);
    read_ok(scratch("one.vti"), &v, NULL);
    assert_memory_equal(v.data, "\1\2\3\4\5\6\7\10", 8);
    pel_volume_finish(&v);
    expect_refused("type='UnstructuredGrid'", IMAGE_TAG, PIECE_TAG, ARRAY_TAG, GOOD, "only ImageData");
    expect_refused(FILE_TAG " byte_order='Middle&#10;Endian'", IMAGE_TAG, PIECE_TAG, ARRAY_TAG, GOOD, "neither LittleEndian");
    expect_refused("type='ImageData' header_type='UInt16'", IMAGE_TAG, PIECE_TAG, ARRAY_TAG, GOOD, "UInt16");
    expect_refused(FILE_TAG " compressor='vtkLZ4DataCompressor'", IMAGE_TAG, PIECE_TAG, ARRAY_TAG, GOOD, "vtkLZ4DataCompressor");
    expect_refused(FILE_TAG " compressor='vtkLZMADataCompressor'", IMAGE_TAG, PIECE_TAG, ARRAY_TAG, GOOD, "vtkLZMADataCompressor");
    expect_refused(FILE_TAG, "", PIECE_TAG, ARRAY_TAG, GOOD, "WholeExtent is missing");
    expect_refused(FILE_TAG, IMAGE_TAG " Spacing='1 1'", PIECE_TAG, ARRAY_TAG, GOOD, "not 3 numbers");
    expect_refused(FILE_TAG, IMAGE_TAG, "Extent='0 -1 0 1 0 1'", ARRAY_TAG, GOOD, "empty");
    expect_refused(FILE_TAG, IMAGE_TAG, "Extent='0 0.5 0 1 0 1'", ARRAY_TAG, GOOD, "no index");
    expect_refused(FILE_TAG, IMAGE_TAG, "Extent='0 1e300 0 1 0 1'", ARRAY_TAG, GOOD, "no index");
    expect_refused(FILE_TAG, IMAGE_TAG, "Extent='-2e9 2e9 -2e9 2e9 -2e9 2e9'", ARRAY_TAG, GOOD, "beyond what can be addressed");
    expect_refused(FILE_TAG, IMAGE_TAG, "Extent='0 9999 0 9999 0 9999'", ARRAY_TAG, GOOD, "not the 1000000000000");
    expect_refused(FILE_TAG, IMAGE_TAG, "Extent='0 9999 0 9999 0 9999'", "type='UInt8'", "1 2 3", "cannot be in a file");
    expect_refused(FILE_TAG, IMAGE_TAG, PIECE_TAG, "type='Float16' Name='a'", GOOD, "Float16");
    expect_refused(FILE_TAG, IMAGE_TAG, PIECE_TAG, "type='String' Name='a'", GOOD, "String");
    expect_refused(FILE_TAG, IMAGE_TAG, PIECE_TAG, "type='UInt8' Name='a' format='telepathic'", GOOD, "telepathic");
    expect_refused(FILE_TAG, IMAGE_TAG, PIECE_TAG, ARRAY_TAG " NumberOfComponents='0'", GOOD, "0 components");
    expect_refused(FILE_TAG, IMAGE_TAG, PIECE_TAG, ARRAY_TAG " NumberOfComponents='9'", GOOD, "9 numbers a sample");
    expect_refused(FILE_TAG, IMAGE_TAG, PIECE_TAG, "type='UInt8' Name='a' format='appended' offset='-1'", "", "offset -1");
    expect_refused(FILE_TAG, IMAGE_TAG, PIECE_TAG, "type='UInt8' Name='a' format='appended'", "", "no AppendedData");
    write_text(scratch("one.vti"), "<!DOCTYPE x [<!ENTITY a 'b'>]><VTKFile type='ImageData'/>");
    expect_bad(scratch("one.vti"), "DOCTYPE");
    write_text(scratch("one.vti"), "<VTKFile type='ImageData'><ImageData WholeExtent='0 1 0 1 0 1'></VTKFile>");
    expect_bad(scratch("one.vti"), "mismatched tag");
}

static void bad_content(void **state)
{
    (void)state;
    expect_refused(FILE_TAG, IMAGE_TAG, PIECE_TAG, ARRAY_TAG, "CAAAAAAAAAABAgMEBQYHC", "too soon");
    expect_refused(FILE_TAG, IMAGE_TAG, PIECE_TAG, ARRAY_TAG, "CAAAAAAAAAABAgME", "too soon");
    expect_refused(FILE_TAG, IMAGE_TAG, PIECE_TAG, ARRAY_TAG, "", "too soon");
    expect_refused(FILE_TAG, IMAGE_TAG, PIECE_TAG, ARRAY_TAG, "CAAA%AAA", "not base64");
    expect_refused(FILE_TAG, IMAGE_TAG, PIECE_TAG, ARRAY_TAG, "CQAAAAAAAAABAgMEBQYHCA==", "not the 8 of the extent");
    expect_refused(FILE_TAG, IMAGE_TAG, PIECE_TAG, ARRAY_TAG, "=AAAAAAA", "not base64");
    expect_refused(FILE_TAG, IMAGE_TAG, PIECE_TAG, "type='UInt8'", "1 2 3 4 5 6 7", "only 7 of 8");
    expect_refused(FILE_TAG, IMAGE_TAG, PIECE_TAG, "type='UInt8'", "1 2 3 4 5 6 7 x", "no number");
}

static void refuse_blocks(const uint64_t *words, size_t count, const char *part)
{
    char text[1024];
    text[base64((const unsigned char *)words, count * 8, text)] = '\0';
    expect_refused(FILE_TAG " compressor='vtkZLibDataCompressor'", IMAGE_TAG, PIECE_TAG, ARRAY_TAG, text, part);
}

/* Block headers that lie, and blocks that unpack to more than they should. */
static void bad_blocks(void **state)
{
    (void)state;
    if (__BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__)
        skip();
    refuse_blocks((const uint64_t[]) { 1, 8, 0, 9999999 }, 4, "claim 9999999 bytes");
    refuse_blocks((const uint64_t[]) { 2, 8, 0, 1, 1 }, 5, "are not the 8 bytes");
    refuse_blocks((const uint64_t[]) { 1, 1ull << 40, 8, 1 }, 4, "too soon"); /* the last block's size is the one that counts */
    refuse_blocks((const uint64_t[]) { 1ull << 61, 1ull << 3, 0, 1 }, 4, "are not the 8 bytes");
    refuse_blocks((const uint64_t[]) { 8, 1, 0 }, 3, "8 blocks cannot be");
    refuse_blocks((const uint64_t[]) { 0, 0, 0 }, 3, "are not the 8 bytes");
    refuse_blocks((const uint64_t[]) { 1, 8, 0, 8, 0x1122334455667788ull }, 5, "zlib block");
    unsigned char block[4 * 8 + 256] = { 1, 0, 0, 0, 0, 0, 0, 0, 8 };
    for (int size = 0; size < 200; size += 4) { /* only 8 is right */
        unsigned char zeros[200] = { 0 };
        char text[1024];
        uLongf packed = 256;
        compress2(block + 32, &packed, zeros, (uLong)size, 9);
        block[24] = (unsigned char)packed;
        text[base64(block, 32 + packed, text)] = '\0';
        write_one(FILE_TAG " compressor='vtkZLibDataCompressor'", IMAGE_TAG, PIECE_TAG, ARRAY_TAG, text);
        struct pel_volume v;
        if (size == 8) {
            read_ok(scratch("one.vti"), &v, NULL);
            pel_volume_finish(&v);
        } else {
            expect_bad(scratch("one.vti"), "zlib block");
        }
    }
}

/* A tag that never ends is not gathered in memory. */
static void endless_tag(void **state)
{
    (void)state;
    size_t size = 64 << 20;
    char *text = malloc(size);
    memset(text, 'x', size);
    memcpy(text, "<VTKFile type='", 15);
    write_gzip(scratch("endless.vti"), text, size);
    free(text);
    expect_bad(scratch("endless.vti"), "longer than");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(facts_of_real_files), cmocka_unit_test(round_trips), cmocka_unit_test(large_round_trip),
        cmocka_unit_test(all_encodings),       cmocka_unit_test(places),      cmocka_unit_test(bad_tags),
        cmocka_unit_test(bad_content),         cmocka_unit_test(bad_blocks),  cmocka_unit_test(endless_tag),
    };
    return cmocka_run_group_tests_name("vti", tests, make_scratch, remove_scratch);
}
