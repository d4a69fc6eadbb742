/* SPDX-License-Identifier: MIT */
/* TIFF: the facts of real slices, every layout of pages, stacks and folders, what ImageJ and OME tell, damage. Pages are written with
 * libtiff. */
#include "support.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <tiffio.h>

#define PLAIN_AXES "axis 0: 1 0 0\naxis 1: 0 1 0\naxis 2: 0 0 1\n"
#define FLAT_NOTE "note: TIFF does not tell the distance of slices: taken as 1 unless --spacing says it\n"

/* How a page is written. Zero means: as simple as can be. */
struct page {
    uint32_t width, height;
    int bits, format, components, compression, photometric;
    bool planes, white_is_zero;
    uint32_t tile, rows; /* edge of a tile; rows of a strip */
    const char *description;
    float x_resolution, y_resolution;
    uint32_t kind;
};

static void facts_of_real_slices(void **state)
{
    (void)state;
    expect_description(data_path("cthead"), "tiff 256x256x99 u8 x1\nspacing 1 1 1\norigin 0 0 0\n" PLAIN_AXES
                                            "space unknown units ''\nmin 0 max 255 mean 31.484447 nonzero 6366912 voids 0\n" FLAT_NOTE);
}

/* The value of a number of slice z: tells its place, in every type. */
static double value_at(const struct page *page, uint32_t x, uint32_t y, uint32_t z, int c)
{
    int value = (int)((x * 7 + y * 13 + z * 31 + (unsigned)c * 3) % 128);
    if (page->bits == 1)
        return value & 1;
    return page->format == SAMPLEFORMAT_INT ? value - 64 : page->format == SAMPLEFORMAT_IEEEFP ? value + 0.25 : value;
}

static void put_value(const struct page *page, unsigned char *out, size_t index, double value)
{
    float f = (float)value;
    int64_t i = (int64_t)value;
    if (page->bits == 1)
        out[index / 8] |= (unsigned char)((int)value << (7 - index % 8));
    else if (page->format != SAMPLEFORMAT_IEEEFP)
        memcpy(out + index * (size_t)page->bits / 8, &i, (size_t)page->bits / 8); /* little-endian machines only, as the test says */
    else if (page->bits == 32)
        memcpy(out + index * 4, &f, 4);
    else
        memcpy(out + index * 8, &value, 8);
}

/* Columns x to x + width of row y, of one component (plane) or, with -1, of all. */
static void fill_row(const struct page *page, uint32_t x, uint32_t width, uint32_t y, uint32_t z, int plane, unsigned char *out)
{
    size_t index = 0;
    for (uint32_t i = x; i < x + width; i++)
        for (int c = plane < 0 ? 0 : plane; c < (plane < 0 ? page->components : plane + 1); c++)
            put_value(page, out, index++, i < page->width && y < page->height ? value_at(page, i, y, z, c) : 0);
}

static void set_tags(TIFF *tiff, const struct page *page)
{
    TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, page->width);
    TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, page->height);
    TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, page->bits);
    TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, page->components);
    TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, page->format);
    TIFFSetField(tiff, TIFFTAG_COMPRESSION, page->compression);
    TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, page->white_is_zero ? PHOTOMETRIC_MINISWHITE : page->photometric);
    TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, page->planes ? PLANARCONFIG_SEPARATE : PLANARCONFIG_CONTIG);
    TIFFSetField(tiff, TIFFTAG_SUBFILETYPE, page->kind);
    if (page->description)
        TIFFSetField(tiff, TIFFTAG_IMAGEDESCRIPTION, page->description);
    if (page->x_resolution > 0) {
        TIFFSetField(tiff, TIFFTAG_XRESOLUTION, page->x_resolution);
        TIFFSetField(tiff, TIFFTAG_YRESOLUTION, page->y_resolution);
    }
    if (page->tile) {
        TIFFSetField(tiff, TIFFTAG_TILEWIDTH, page->tile);
        TIFFSetField(tiff, TIFFTAG_TILELENGTH, page->tile);
    } else {
        TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, page->rows);
    }
}

static void complete(struct page *page)
{
    page->width = page->width ? page->width : 21;
    page->height = page->height ? page->height : 18;
    page->bits = page->bits ? page->bits : 8;
    page->format = page->format ? page->format : SAMPLEFORMAT_UINT;
    page->components = page->components ? page->components : 1;
    page->compression = page->compression ? page->compression : COMPRESSION_NONE;
    page->photometric = page->photometric ? page->photometric : page->components == 3 ? PHOTOMETRIC_RGB : PHOTOMETRIC_MINISBLACK;
    page->rows = page->rows ? page->rows : 5;
}

static void write_page(TIFF *tiff, struct page page, uint32_t z)
{
    unsigned char bytes[1 << 14];
    complete(&page);
    set_tags(tiff, &page);
    for (int plane = page.planes ? 0 : -1; plane < (page.planes ? page.components : 0); plane++) {
        for (uint32_t y = 0; !page.tile && y < page.height; y++) {
            memset(bytes, 0, sizeof bytes);
            fill_row(&page, 0, page.width, y, z, plane, bytes);
            assert_int_equal(TIFFWriteScanline(tiff, bytes, y, (uint16_t)(plane < 0 ? 0 : plane)), 1);
        }
        for (uint32_t y = 0; page.tile && y < page.height; y += page.tile)
            for (uint32_t x = 0; x < page.width; x += page.tile) {
                memset(bytes, 0, sizeof bytes);
                tmsize_t pitch = TIFFTileRowSize(tiff);
                for (uint32_t row = 0; row < page.tile; row++)
                    fill_row(&page, x, page.tile, y + row, z, plane, bytes + row * (size_t)pitch);
                assert_true(TIFFWriteTile(tiff, bytes, x, y, 0, (uint16_t)(plane < 0 ? 0 : plane)) > 0);
            }
    }
    assert_int_equal(TIFFWriteDirectory(tiff), 1);
}

/* mode: libtiff's, such as "wb" for big-endian or "w8" for BigTIFF. */
static void write_pages(const char *path, const char *mode, const struct page *page, uint32_t count)
{
    TIFF *tiff = TIFFOpen(path, mode);
    assert_non_null(tiff);
    for (uint32_t z = 0; z < count; z++)
        write_page(tiff, *page, z);
    TIFFClose(tiff);
}

static void expect_pages(const char *path, const struct page *given, uint32_t count, enum pel_type type)
{
    struct pel_volume v;
    struct page page = *given;
    complete(&page);
    read_ok(path, &v, NULL);
    assert_int_equal(v.type, type);
    assert_int_equal(v.components, page.components);
    assert_true(v.dims[0] == page.width && v.dims[1] == page.height && v.dims[2] == count);
    for (uint32_t z = 0; z < count; z++)
        for (uint32_t y = 0; y < page.height; y++)
            for (uint32_t x = 0; x < page.width; x++)
                for (int c = 0; c < page.components; c++)
                    assert_true(pel_volume_get(&v, x, y, z, c) == value_at(&page, x, y, z, c));
    pel_volume_finish(&v);
}

static void layouts(void **state)
{
    (void)state;
    static const struct {
        int bits, format;
        enum pel_type type;
    } types[] = {
        { 8, SAMPLEFORMAT_UINT, PEL_U8 },     { 8, SAMPLEFORMAT_INT, PEL_I8 },      { 16, SAMPLEFORMAT_UINT, PEL_U16 },
        { 16, SAMPLEFORMAT_INT, PEL_I16 },    { 32, SAMPLEFORMAT_UINT, PEL_U32 },   { 32, SAMPLEFORMAT_INT, PEL_I32 },
        { 32, SAMPLEFORMAT_IEEEFP, PEL_F32 }, { 64, SAMPLEFORMAT_IEEEFP, PEL_F64 }, { 1, SAMPLEFORMAT_UINT, PEL_U8 },
    };
    static const char *const modes[] = { "wl", "wb", "wl8" };
    static const int compressions[] = { COMPRESSION_NONE, COMPRESSION_LZW, COMPRESSION_ADOBE_DEFLATE, COMPRESSION_PACKBITS };
    for (size_t t = 0; t < sizeof types / sizeof *types; t++)
        for (int i = 0; i < 96; i++) { /* mode, compression, tiles, planes and components in turn */
            struct page page = { .bits = types[t].bits,
                                 .format = types[t].format,
                                 .compression = compressions[i / 3 % 4],
                                 .tile = i / 12 % 2 ? 16 : 0,
                                 .components = i / 24 % 2 ? 1 + i / 48 * 2 : 1 + i / 48,
                                 .planes = i % 2 };
            if (page.bits == 1 && page.components > 1)
                continue;
            write_pages(scratch("a.tif"), modes[i % 3], &page, 2);
            expect_pages(scratch("a.tif"), &page, 2, types[t].type);
        }
}

static void write_folder(const char *name, const char *const *names, size_t count, const struct page *page)
{
    char path[512];
    mkdir(scratch(name), 0777);
    for (size_t z = 0; z < count; z++) {
        snprintf(path, sizeof path, "%s/%s", scratch(name), names[z]);
        TIFF *tiff = TIFFOpen(path, "w");
        assert_non_null(tiff);
        write_page(tiff, *page, (uint32_t)z);
        TIFFClose(tiff);
    }
}

static void folders(void **state)
{
    (void)state;
    static const char *const names[] = { "s-1.tif", "s-2.tif", "s-9.TIFF", "s-10.tif", "s-011.tif", "s-100.tif" };
    struct page page = { .bits = 16 }, other = { .bits = 16, .width = 20 }, wide = { .bits = 8 };
    char path[512];
    write_folder("stack", names, 6, &page);
    snprintf(path, sizeof path, "%s/notes.txt", scratch("stack"));
    write_text(path, "not a slice");
    expect_pages(scratch("stack"), &page, 6, PEL_U16);
    snprintf(path, sizeof path, "%s/s-9.TIFF", scratch("stack"));
    write_pages(path, "w", &other, 1);
    expect_bad(scratch("stack"), "s-9.TIFF: has 20 x 18 pixels of 1 x u16, the first slice has 21 x 18 of 1 x u16; all must agree");
    write_pages(path, "w", &wide, 1);
    expect_bad(scratch("stack"), "s-9.TIFF: has 21 x 18 pixels of 1 x u8");
    write_pages(path, "w", &page, 2);
    expect_bad(scratch("stack"), "s-9.TIFF: has several pages");
    write_text(path, "II*");
    expect_bad(scratch("stack"), "s-9.TIFF: is no TIFF file");
    mkdir(scratch("empty"), 0777);
    expect_bad(scratch("empty"), "folder");
}

static void pages_that_differ(void **state)
{
    (void)state;
    struct page page = { .bits = 8 }, other = { .bits = 8, .height = 17 },
                small = { .width = 5, .height = 5, .kind = FILETYPE_REDUCEDIMAGE };
    TIFF *tiff = TIFFOpen(scratch("d.tif"), "w");
    write_page(tiff, page, 0);
    write_page(tiff, other, 1);
    TIFFClose(tiff);
    expect_bad(scratch("d.tif"), "page 2 has 21 x 17 pixels");
    tiff = TIFFOpen(scratch("r.tif"), "w"); /* thumbnails are no slices */
    write_page(tiff, small, 0);
    write_page(tiff, page, 0);
    write_page(tiff, small, 0);
    write_page(tiff, page, 1);
    TIFFClose(tiff);
    expect_pages(scratch("r.tif"), &page, 2, PEL_U8);
}

static void expect_placed(const struct page *page, uint32_t count, const char *golden)
{
    write_pages(scratch("p.tif"), "w", page, count);
    static struct pel_file_info info;
    struct pel_volume v;
    char text[1024];
    size_t n;
    read_ok(scratch("p.tif"), &v, &info);
    n = (size_t)snprintf(text, sizeof text, "%zu: %.6g %.6g %.6g '%s'\n", v.dims[2], v.spacing[0], v.spacing[1], v.spacing[2], v.units);
    for (int i = 0; i < info.note_count; i++)
        n += (size_t)snprintf(text + n, sizeof text - n, "note: %s\n", info.notes[i]);
    pel_volume_finish(&v);
    assert_string_equal(text, golden);
}

static void spacings(void **state)
{
    (void)state;
    expect_placed(&(struct page) { .x_resolution = 72, .y_resolution = 72 }, 2, "2: 1 1 1 ''\n" FLAT_NOTE);
    expect_placed(&(struct page) { .x_resolution = 204, .y_resolution = 102 }, 1, "1: 1 2 1 ''\n");
    expect_placed(
        &(struct page) { .x_resolution = 4, .y_resolution = 2, .description = "ImageJ=1.53\nimages=2\nunit=micron\nspacing=3.5\n" }, 2,
        "2: 0.25 0.5 3.5 'um'\n");
    expect_placed(&(struct page) { .description = "<OME><Pixels PhysicalSizeX=\"0.5\" PhysicalSizeXUnit=\"nm\" PhysicalSizeY=\"0.25\" "
                                                  "PhysicalSizeZ=\"2\"/></OME>" },
                  2, "2: 0.5 0.25 2 'nm'\n");
    expect_placed(&(struct page) { .description = "ImageJ=1.53\nimages=6\nchannels=2\nslices=3\nspacing=2\n" }, 6,
                  "3: 1 1 2 ''\nnote: a hyperstack of 2 channels and 1 times: the first channel at the first time is read\n");
    expect_placed(&(struct page) { .white_is_zero = true }, 1,
                  "1: 1 1 1 ''\nnote: the file says that 0 is white; the values are as stored\n");
}

/* ImageJ writes stacks beyond 4 GB with the tags of the first page alone, the others lying behind it. */
static void run_of_slices(void **state)
{
    (void)state;
    struct page page = { .bits = 16, .rows = 18, .description = "ImageJ=1.53\nimages=3\n" };
    struct pel_volume v;
    write_pages(scratch("one.tif"), "wb", &page, 1);
    size_t size;
    unsigned char *bytes = read_file(scratch("one.tif"), &size), *grown = calloc(size + 3 * 756, 1);
    memcpy(grown, bytes, size);
    memcpy(grown + size, bytes + 8, 756); /* libtiff puts the strip right behind the header: one copy, then one less */
    write_file(scratch("short.tif"), grown, 8 + 3 * 756 - 1 > size ? 8 + 3 * 756 - 1 : size);
    write_file(scratch("run.tif"), grown, size + 3 * 756);
    free(bytes);
    free(grown);
    read_ok(scratch("run.tif"), &v, NULL);
    complete(&page);
    assert_int_equal(v.dims[2], 3);
    for (uint32_t y = 0; y < 18; y++)
        for (uint32_t x = 0; x < 21; x++)
            assert_true(pel_volume_get(&v, x, y, 0, 0) == value_at(&page, x, y, 0, 0));
    pel_volume_finish(&v);
    read_bad(scratch("short.tif"), NULL);
}

static void gzipped(void **state)
{
    (void)state;
    struct page page = { .bits = 16 };
    size_t size;
    write_pages(scratch("g.tif"), "w", &page, 3);
    unsigned char *bytes = read_file(scratch("g.tif"), &size);
    write_gzip(scratch("g.tif.gz"), bytes, size);
    free(bytes);
    expect_pages(scratch("g.tif.gz"), &page, 3, PEL_U16);
}

/* Overwrites the value of a tag of the first page of a little-endian file, of type SHORT or LONG. */
static void patch_tag(const char *path, const char *out, unsigned tag, uint32_t value)
{
    size_t size;
    unsigned char *bytes = read_file(path, &size);
    uint32_t at;
    bool found = false;
    memcpy(&at, bytes + 4, 4);
    int count = bytes[at] | bytes[at + 1] << 8;
    for (int i = 0; i < count; i++) {
        unsigned char *entry = bytes + at + 2 + (ptrdiff_t)(12 * i);
        if ((unsigned)(entry[0] | entry[1] << 8) == tag) {
            entry[2] = 4;
            memcpy(entry + 8, &value, 4);
            found = true;
        }
    }
    assert_true(found);
    write_file(out, bytes, size);
    free(bytes);
}

static void bad_files(void **state)
{
    (void)state;
    struct page page = { .bits = 16, .rows = 18 }, packed = { .bits = 16, .rows = 18, .compression = COMPRESSION_LZW },
                tiled = { .tile = 16 };
    size_t size;
    write_pages(scratch("t.tif"), "wl", &page, 1);
    free(read_file(scratch("t.tif"), &size));
    expect_truncations_fail(scratch("t.tif"), scratch("cut.tif"), size - 16);
    patch_tag(scratch("t.tif"), scratch("bad.tif"), TIFFTAG_IMAGEWIDTH, 4000000000u);
    read_bad(scratch("bad.tif"), NULL);
    patch_tag(scratch("t.tif"), scratch("bad.tif"), TIFFTAG_IMAGELENGTH, 4000000);
    read_bad(scratch("bad.tif"), NULL);
    patch_tag(scratch("t.tif"), scratch("bad.tif"), TIFFTAG_IMAGEWIDTH, 0);
    read_bad(scratch("bad.tif"), NULL);
    patch_tag(scratch("t.tif"), scratch("bad.tif"), TIFFTAG_SAMPLESPERPIXEL, 5);
    read_bad(scratch("bad.tif"), NULL);
    patch_tag(scratch("t.tif"), scratch("bad.tif"), TIFFTAG_BITSPERSAMPLE, 12);
    expect_bad(scratch("bad.tif"), "12 bits");
    patch_tag(scratch("t.tif"), scratch("bad.tif"), TIFFTAG_COMPRESSION, 54321);
    expect_bad(scratch("bad.tif"), "compression 54321");
    patch_tag(scratch("t.tif"), scratch("bad.tif"), TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_CIELAB);
    expect_bad(scratch("bad.tif"), "colour space 8");
    patch_tag(scratch("t.tif"), scratch("bad.tif"), TIFFTAG_STRIPOFFSETS, 0x7ffffff0);
    read_bad(scratch("bad.tif"), NULL);
    write_pages(scratch("t.tif"), "wl", &packed, 1);
    patch_tag(scratch("t.tif"), scratch("bad.tif"), TIFFTAG_IMAGEWIDTH, 60000);
    read_bad(scratch("bad.tif"), NULL);
    write_pages(scratch("t.tif"), "wl", &tiled, 1);
    patch_tag(scratch("t.tif"), scratch("bad.tif"), TIFFTAG_TILEWIDTH, 0x7fffff00);
    read_bad(scratch("bad.tif"), NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(facts_of_real_slices),
        cmocka_unit_test(layouts),
        cmocka_unit_test(folders),
        cmocka_unit_test(pages_that_differ),
        cmocka_unit_test(spacings),
        cmocka_unit_test(run_of_slices),
        cmocka_unit_test(gzipped),
        cmocka_unit_test(bad_files),
    };
    TIFFSetWarningHandler(NULL);
    return cmocka_run_group_tests_name("tiff", tests, make_scratch, remove_scratch);
}
