/* SPDX-License-Identifier: MIT */
/* Writing VTK XML ImageData (.vti): appended raw data, in zlib blocks where compression is asked for. What a volume has and ImageData has
 * not (units, the meaning of the axes, the void value) goes into FieldData, where VTK keeps it and our reader finds it again. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#include "alloc.h"
#include "fail.h"
#include "vti.h"

#define BLOCK (1u << 18) /* bytes of samples that are packed together */
#define PIECE (1u << 24) /* bytes written between two reports of progress */

static const char *type_name(enum pel_type type)
{
    static const char *const names[PEL_TYPE_COUNT] = { "UInt8", "Int8", "UInt16", "Int16", "UInt32", "Int32", "Float32", "Float64" };
    return names[type];
}

/* Text with the characters that XML needs escaped; what is no UTF-8 is replaced, for a parser would stop at it. */
static void write_text(FILE *file, const char *text)
{
    for (const unsigned char *at = (const unsigned char *)text; *at; at++) {
        int more = *at >= 0xf0 && *at < 0xf5 ? 3 : *at >= 0xe0 && *at < 0xf0 ? 2 : *at >= 0xc2 && *at < 0xe0 ? 1 : 0;
        bool good = *at < 0x80 || more;
        for (int i = 1; i <= more; i++)
            good = good && (at[i] & 0xc0) == 0x80;
        if (*at >= 0x80 && good)
            good = !(at[0] == 0xe0 && at[1] < 0xa0) && !(at[0] == 0xed && at[1] > 0x9f) && !(at[0] == 0xf0 && at[1] < 0x90) &&
                   !(at[0] == 0xf4 && at[1] > 0x8f) && !(at[0] == 0xef && at[1] == 0xbf && at[2] >= 0xbe);
        if (!good || *at < ' ' || *at == 0x7f) {
            fputc('?', file);
        } else if (strchr("<>&\"'", *at)) {
            fprintf(file, "&#%d;", *at);
        } else {
            fwrite(at, 1, (size_t)more + 1, file);
            at += more;
        }
    }
}

/* A string as VTK writes it: the codes of its bytes, and 0. */
static void write_string(FILE *file, const char *name, const char *text)
{
    fprintf(file, "      <Array type=\"String\" Name=\"%s\" NumberOfTuples=\"1\" format=\"ascii\">\n        ", name);
    for (const char *at = text; *at; at++)
        fprintf(file, "%d ", (unsigned char)*at);
    fputs("0\n      </Array>\n", file);
}

static void write_field(FILE *file, const struct pel_volume *volume)
{
    bool space = volume->space != PEL_SPACE_UNKNOWN;
    if (!*volume->units && !space && !volume->has_void && !volume->labels)
        return;
    fputs("    <FieldData>\n", file);
    if (*volume->units)
        write_string(file, PEL_VTI_UNITS, volume->units);
    if (space)
        write_string(file, PEL_VTI_SPACE, pel_space_name(volume->space));
    if (volume->has_void)
        fprintf(file,
                "      <DataArray type=\"Float64\" Name=\"" PEL_VTI_VOID "\" NumberOfTuples=\"1\" format=\"ascii\">%.17g</DataArray>\n",
                volume->void_value);
    if (volume->labels)
        fputs("      <DataArray type=\"UInt8\" Name=\"" PEL_VTI_LABELS "\" NumberOfTuples=\"1\" format=\"ascii\">1</DataArray>\n", file);
    fputs("    </FieldData>\n", file);
}

/* Everything up to the '_' in front of the samples. */
static void write_head(FILE *file, const struct pel_volume *volume, bool compress)
{
    const double(*d)[3] = volume->direction;
    const size_t last[3] = { volume->dims[0] - 1, volume->dims[1] - 1, volume->dims[2] - 1 };
    const char *name = *volume->name ? volume->name : "values";
    fprintf(file, "<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"%s\" header_type=\"UInt64\"%s>\n",
            PEL_HOST_BIG_ENDIAN ? "BigEndian" : "LittleEndian", compress ? " compressor=\"vtkZLibDataCompressor\"" : "");
    fprintf(file, "  <ImageData WholeExtent=\"0 %zu 0 %zu 0 %zu\" Origin=\"%.17g %.17g %.17g\" Spacing=\"%.17g %.17g %.17g\" ", last[0],
            last[1], last[2], volume->origin[0], volume->origin[1], volume->origin[2], volume->spacing[0], volume->spacing[1],
            volume->spacing[2]);
    fprintf(file, "Direction=\"%.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g\">\n", d[0][0], d[1][0], d[2][0], d[0][1], d[1][1],
            d[2][1], d[0][2], d[1][2], d[2][2]);
    write_field(file, volume);
    fprintf(file, "    <Piece Extent=\"0 %zu 0 %zu 0 %zu\">\n      <PointData %s=\"", last[0], last[1], last[2],
            volume->components == 3 ? "Vectors" : "Scalars");
    write_text(file, name);
    fprintf(file, "\">\n        <DataArray type=\"%s\" Name=\"", type_name(volume->type));
    write_text(file, name);
    fprintf(file, "\" NumberOfComponents=\"%d\" format=\"appended\" offset=\"0\"/>\n      </PointData>\n      <CellData/>\n    </Piece>\n",
            volume->components);
    fputs("  </ImageData>\n  <AppendedData encoding=\"raw\">\n   _", file);
}

static bool write_plain(struct pel_safe_file *out, const struct pel_volume *volume, const struct pel_progress *progress,
                        struct pel_error *error)
{
    const char *data = volume->data;
    uint64_t bytes = pel_volume_bytes(volume);
    if (!pel_safe_file_write(out, &bytes, sizeof bytes, error))
        return false;
    for (uint64_t at = 0; at < bytes; at += PIECE) {
        size_t piece = bytes - at < PIECE ? (size_t)(bytes - at) : PIECE;
        if (!pel_progress_report(progress, (double)at / (double)bytes, error) || !pel_safe_file_write(out, data + at, piece, error))
            return false;
    }
    return true;
}

/* The blocks' packed sizes stand in front of the blocks: room is left for them, and they are filled in at the end. */
static bool write_blocks(struct pel_safe_file *out, const struct pel_volume *volume, uint64_t *header, size_t words, unsigned char *packed,
                         const struct pel_progress *progress, struct pel_error *error)
{
    const unsigned char *data = volume->data;
    size_t bytes = pel_volume_bytes(volume), count = words - 3;
    off_t place = ftello(out->file);
    if (place < 0)
        return pel_fail(error, PEL_ERROR_ARGUMENT, "compressed data cannot be written into a pipe; write a file, or write uncompressed");
    if (!pel_safe_file_write(out, header, words * sizeof *header, error))
        return false;
    for (size_t i = 0; i < count; i++) {
        size_t piece = bytes - i * BLOCK < BLOCK ? bytes - i * BLOCK : BLOCK;
        uLongf size = compressBound(BLOCK);
        if (!pel_progress_report(progress, (double)i / (double)count, error))
            return false;
        if (compress2(packed, &size, data + i * BLOCK, (uLong)piece, 5) != Z_OK)
            return pel_fail(error, PEL_ERROR_MEMORY, "no memory for zlib");
        header[3 + i] = size;
        if (!pel_safe_file_write(out, packed, size, error))
            return false;
    }
    if (fseeko(out->file, place, SEEK_SET) != 0)
        return pel_fail_errno(error, "cannot go back to the block sizes");
    if (!pel_safe_file_write(out, header, words * sizeof *header, error))
        return false;
    return fseeko(out->file, 0, SEEK_END) == 0 || pel_fail_errno(error, "cannot go to the end");
}

static bool write_compressed(struct pel_safe_file *out, const struct pel_volume *volume, const struct pel_progress *progress,
                             struct pel_error *error)
{
    size_t bytes = pel_volume_bytes(volume), count = bytes / BLOCK + (bytes % BLOCK != 0), words = 3 + count;
    uint64_t *header = pel_alloc(words, sizeof *header, "block sizes", error);
    unsigned char *packed = header ? pel_alloc(compressBound(BLOCK), 1, "a compressed block", error) : NULL;
    bool ok = false;
    if (packed) {
        header[0] = count;
        header[1] = BLOCK;
        header[2] = bytes % BLOCK;
        ok = write_blocks(out, volume, header, words, packed, progress, error);
    }
    free(packed);
    free(header);
    return ok;
}

bool pel_vti_write(const char *path, const struct pel_volume *volume, const struct pel_write_params *params, struct pel_error *error)
{
    struct pel_safe_file out;
    if (!pel_safe_file_open(&out, path, error))
        return false;
    write_head(out.file, volume, params->compress);
    bool ok =
        params->compress ? write_compressed(&out, volume, &params->progress, error) : write_plain(&out, volume, &params->progress, error);
    fputs("\n  </AppendedData>\n</VTKFile>\n", out.file);
    ok = ok && pel_safe_file_commit(&out, error);
    pel_safe_file_abort(&out);
    return ok;
}
