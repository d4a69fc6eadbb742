/* SPDX-License-Identifier: MIT */
/* The header of one DICOM file (PS3.5 and PS3.10): data elements, one after the other, some of them sequences of items that again hold data
 * elements.
 *
 * This walk is ours and not a library's: every length is held against what is left of the file or of the enclosing element, and nothing is
 * allocated by what a length says; libraries allocate first. Only the few elements that place and decode pixels are looked at. */
#include "dicom_file.h"

#include <locale.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "alloc.h"
#include "fail.h"
#include "format.h"

#define UNDEFINED 0xffffffffu
#define DEEPEST 32

/* clang-format off */
enum tag {
    TAG_SYNTAX = 0x00020010, TAG_MODALITY = 0x00080060, TAG_DESCRIPTION = 0x0008103e, TAG_THICKNESS = 0x00180050,
    TAG_BETWEEN = 0x00180088, TAG_IMAGER_SPACING = 0x00181164, TAG_SERIES_UID = 0x0020000e, TAG_SERIES_NUMBER = 0x00200011,
    TAG_ACQUISITION = 0x00200012, TAG_INSTANCE = 0x00200013, TAG_POSITION = 0x00200032, TAG_ORIENTATION = 0x00200037,
    TAG_SAMPLES = 0x00280002, TAG_PHOTOMETRIC = 0x00280004, TAG_PLANES = 0x00280006, TAG_FRAMES = 0x00280008, TAG_ROWS = 0x00280010,
    TAG_COLUMNS = 0x00280011, TAG_SPACING = 0x00280030, TAG_ALLOCATED = 0x00280100, TAG_STORED = 0x00280101, TAG_HIGH_BIT = 0x00280102,
    TAG_SIGNED = 0x00280103, TAG_INTERCEPT = 0x00281052, TAG_SLOPE = 0x00281053,
    /* sequences of multi-frame images */
    TAG_SHARED_GROUPS = 0x52009229, TAG_FRAME_GROUPS = 0x52009230, TAG_PLANE_POSITION = 0x00209113, TAG_PLANE_ORIENTATION = 0x00209116,
    TAG_PIXEL_MEASURES = 0x00289110, TAG_VALUE_TRANSFORM = 0x00289145,
};
/* clang-format on */
#define TAG_FLOAT_PIXELS 0x7fe00008u
#define TAG_DOUBLE_PIXELS 0x7fe00009u
#define TAG_PIXELS 0x7fe00010u
#define TAG_ITEM 0xfffee000u
#define TAG_ITEM_END 0xfffee00du
#define TAG_SEQUENCE_END 0xfffee0ddu

/* The file, through a window that moves along. */
struct walk {
    FILE *stream;
    uint64_t length;
    unsigned char window[1 << 13];
    uint64_t start;
    size_t held;
    bool explicit_vr, big_endian;
    locale_t locale;
    struct pel_dicom_file *file;
    struct pel_error *error;
    bool done; /* pixel data were met: nothing of use comes after them */
};

/* One element's beginning. */
struct element {
    uint32_t tag, length; /* length may be UNDEFINED */
    char vr[3];           /* "" where it is implicit */
    uint64_t value;       /* where the value stands */
};

/* Where in the tree of sequences the walk is. */
struct place {
    int depth;
    uint32_t sequence;             /* the innermost one's tag, or 0 */
    struct pel_dicom_frame *frame; /* whom a functional group describes */
};

/* `size` bytes at `offset`, at most 4096; NULL where the file ends sooner. */
static const unsigned char *look(struct walk *w, uint64_t offset, size_t size)
{
    if (offset > w->length || size > w->length - offset)
        return NULL;
    if (offset < w->start || offset + size > w->start + w->held) {
        w->start = offset;
        w->held = fseeko(w->stream, (off_t)offset, SEEK_SET) == 0 ? fread(w->window, 1, sizeof w->window, w->stream) : 0;
        if (w->held < size)
            return NULL;
    }
    return w->window + (offset - w->start);
}

static uint32_t number16(const struct walk *w, const unsigned char *p)
{
    return w->big_endian ? (uint32_t)p[0] << 8 | p[1] : (uint32_t)p[1] << 8 | p[0];
}

static uint32_t number32(const struct walk *w, const unsigned char *p)
{
    return w->big_endian ? number16(w, p) << 16 | number16(w, p + 2) : number16(w, p + 2) << 16 | number16(w, p);
}

static bool ends_early(struct walk *w, uint64_t at)
{
    return pel_fail(w->error, PEL_ERROR_FORMAT, "the file ends inside of the header, at byte %llu", (unsigned long long)at);
}

static bool read_element(struct walk *w, uint64_t at, struct element *e)
{
    const unsigned char *p = look(w, at, 8);
    if (!p)
        return ends_early(w, at);
    e->tag = number16(w, p) << 16 | number16(w, p + 2);
    e->vr[0] = '\0';
    e->value = at + 8;
    if (e->tag >> 16 == 0xfffe || !w->explicit_vr) {
        e->length = number32(w, p + 4);
        return true;
    }
    memcpy(e->vr, p + 4, 2);
    e->vr[2] = '\0';
    if (e->vr[0] < 'A' || e->vr[0] > 'Z' || e->vr[1] < 'A' || e->vr[1] > 'Z')
        return pel_fail(w->error, PEL_ERROR_FORMAT, "byte %llu: no value representation where one belongs", (unsigned long long)at + 4);
    if (!strstr("OB OW OF OD OL OV SQ UC UR UT UN SV UV", e->vr)) {
        e->length = number16(w, p + 6);
        return true;
    }
    if (!(p = look(w, at + 8, 4)))
        return ends_early(w, at);
    e->length = number32(w, p);
    e->value = at + 12;
    return true;
}

/* Text without the padding at its end. */
static void take_text(struct walk *w, const struct element *e, char *out, size_t size)
{
    size_t length = e->length < size - 1 ? e->length : size - 1;
    const unsigned char *p = look(w, e->value, length);
    char text[256] = "";
    if (p && length < sizeof text) {
        memcpy(text, p, length);
        text[length] = '\0';
    }
    pel_copy_text(out, size, text + strspn(text, " "));
}

/* Decimal strings between backslashes. False where there are fewer than `count` numbers. */
static bool take_decimals(struct walk *w, const struct element *e, int count, double *out)
{
    char text[256], *at = text, *end;
    double values[6];
    take_text(w, e, text, sizeof text);
    for (int i = 0; i < count; i++) {
        values[i] = strtod_l(at, &end, w->locale);
        if (end == at || !(values[i] - values[i] == 0))
            return false;
        at = end + strspn(end, " ");
        at += *at == '\\';
    }
    memcpy(out, values, (size_t)count * sizeof *out);
    return true;
}

static int take_integer(struct walk *w, const struct element *e)
{
    double value = 0;
    return take_decimals(w, e, 1, &value) && value > -2e9 && value < 2e9 ? (int)value : 0;
}

static int take_short(struct walk *w, const struct element *e)
{
    const unsigned char *p = e->length >= 2 ? look(w, e->value, 2) : NULL;
    return p ? (int)number16(w, p) : 0;
}

/* What places a frame, and what its numbers mean. */
static void take_frame(struct walk *w, const struct element *e, struct pel_dicom_frame *frame)
{
    double pair[2];
    double *number = e->tag == TAG_SLOPE       ? &frame->slope
                     : e->tag == TAG_INTERCEPT ? &frame->intercept
                     : e->tag == TAG_THICKNESS ? &w->file->thickness
                     : e->tag == TAG_BETWEEN   ? &w->file->between
                                               : NULL;
    if (number)
        take_decimals(w, e, 1, number);
    else if (e->tag == TAG_POSITION)
        frame->has_position = take_decimals(w, e, 3, frame->position);
    else if (e->tag == TAG_ORIENTATION)
        frame->has_orientation = take_decimals(w, e, 6, frame->orientation);
    else if ((e->tag == TAG_SPACING || (e->tag == TAG_IMAGER_SPACING && !frame->has_spacing)) && take_decimals(w, e, 2, pair) &&
             pair[0] > 0 && pair[1] > 0) {
        frame->has_spacing = true;
        frame->spacing[0] = pair[1];
        frame->spacing[1] = pair[0];
    }
}

/* Elements that are copied as they are: text, a number of two bytes, or one in decimals, into an int. */
static const struct {
    uint32_t tag;
    enum { TEXT, SHORT, DECIMAL } kind;
    size_t offset, size;
} copied[] = {
#define FIELD(TAG, KIND, NAME)                                                                                                             \
    {                                                                                                                                      \
        TAG, KIND, offsetof(struct pel_dicom_file, NAME), sizeof((struct pel_dicom_file *)NULL)->NAME                                      \
    }
    FIELD(TAG_SYNTAX, TEXT, syntax),
    FIELD(TAG_MODALITY, TEXT, modality),
    FIELD(TAG_DESCRIPTION, TEXT, description),
    FIELD(TAG_SERIES_UID, TEXT, series_uid),
    FIELD(TAG_PHOTOMETRIC, TEXT, pixels.photometric),
    FIELD(TAG_SERIES_NUMBER, DECIMAL, series_number),
    FIELD(TAG_ACQUISITION, DECIMAL, acquisition_number),
    FIELD(TAG_INSTANCE, DECIMAL, instance_number),
    FIELD(TAG_SAMPLES, SHORT, pixels.samples),
    FIELD(TAG_ROWS, SHORT, pixels.rows),
    FIELD(TAG_COLUMNS, SHORT, pixels.columns),
    FIELD(TAG_ALLOCATED, SHORT, pixels.allocated),
    FIELD(TAG_STORED, SHORT, pixels.stored),
    FIELD(TAG_HIGH_BIT, SHORT, pixels.high_bit),
#undef FIELD
};

/* Everything else, which stands outside of sequences. */
static void take_file(struct walk *w, const struct element *e)
{
    struct pel_dicom_file *f = w->file;
    double frames = 0;
    for (size_t i = 0; i < sizeof copied / sizeof *copied; i++) {
        char *field = (char *)f + copied[i].offset;
        if (copied[i].tag != e->tag)
            continue;
        int number = copied[i].kind == SHORT ? take_short(w, e) : copied[i].kind == DECIMAL ? take_integer(w, e) : 0;
        if (copied[i].kind == TEXT)
            take_text(w, e, field, copied[i].size);
        else
            memcpy(field, &number, sizeof number);
        return;
    }
    if (e->tag == TAG_PLANES) {
        f->pixels.planes = take_short(w, e) == 1;
    } else if (e->tag == TAG_SIGNED) {
        f->pixels.is_signed = take_short(w, e) == 1;
    } else if (e->tag == TAG_FRAMES) {
        take_decimals(w, e, 1, &frames);
        f->frame_count = frames > 1 ? (frames < 9e15 ? (uint64_t)frames : (uint64_t)9e15) : 1;
    } else {
        take_frame(w, e, &f->shared);
    }
}

static void take_element(struct walk *w, const struct element *e, const struct place *place)
{
    uint32_t s = place->sequence;
    if (place->depth == 0)
        take_file(w, e);
    else if (place->frame && (s == TAG_PLANE_POSITION || s == TAG_PLANE_ORIENTATION || s == TAG_PIXEL_MEASURES || s == TAG_VALUE_TRANSFORM))
        take_frame(w, e, place->frame);
}

/* A new frame, of which all is known that is shared. */
static struct pel_dicom_frame *add_frame(struct walk *w)
{
    struct pel_dicom_file *f = w->file;
    if ((f->described & (f->described - 1)) == 0) {
        size_t room = f->described ? (size_t)f->described * 2 : 1;
        struct pel_dicom_frame *grown = realloc(f->frames, room * sizeof *grown);
        if (!grown) {
            pel_fail(w->error, PEL_ERROR_MEMORY, "no memory for %zu frames", room);
            return NULL;
        }
        f->frames = grown;
    }
    f->frames[f->described] = f->shared;
    return &f->frames[f->described++];
}

static bool walk_elements(struct walk *w, uint64_t *at, uint64_t end, struct place place);

/* The items of a sequence, from *at to `end`, or to its end mark where its length is undefined. The items of compressed pixels (of an icon,
 * say) are only bytes. */
static bool walk_items(struct walk *w, uint64_t *at, uint64_t end, const struct element *e, struct place place)
{
    struct element item;
    uint32_t tag = e->tag;
    bool only_bytes = tag == TAG_PIXELS || e->vr[0] == 'O', marked = e->length == UNDEFINED;
    struct place inside = { .depth = place.depth + 1, .sequence = tag, .frame = place.frame };
    if (place.depth >= DEEPEST)
        return pel_fail(w->error, PEL_ERROR_FORMAT, "sequences are nested more than %d deep", DEEPEST);
    while (*at < end) {
        if (!read_element(w, *at, &item))
            return false;
        *at = item.value;
        if (item.tag == TAG_SEQUENCE_END)
            return true;
        if (item.tag != TAG_ITEM)
            return pel_fail(w->error, PEL_ERROR_FORMAT, "byte %llu: no item of a sequence where one belongs", (unsigned long long)*at - 8);
        if (item.length != UNDEFINED ? item.length > end - *at : only_bytes)
            return ends_early(w, *at);
        if (only_bytes) {
            *at += item.length;
            continue;
        }
        if (place.depth == 0 && (tag == TAG_SHARED_GROUPS || tag == TAG_FRAME_GROUPS)) {
            inside.frame = tag == TAG_SHARED_GROUPS ? &w->file->shared : add_frame(w);
            if (!inside.frame)
                return false;
        }
        if (!walk_elements(w, at, item.length == UNDEFINED ? end : *at + item.length, inside))
            return false;
    }
    return !marked || ends_early(w, *at);
}

static bool is_group(uint32_t tag)
{
    return tag == TAG_SHARED_GROUPS || tag == TAG_FRAME_GROUPS || tag == TAG_PLANE_POSITION || tag == TAG_PLANE_ORIENTATION ||
           tag == TAG_PIXEL_MEASURES || tag == TAG_VALUE_TRANSFORM;
}

static void take_pixels(struct walk *w, const struct element *e)
{
    w->file->has_pixels = w->done = true;
    w->file->pixels.is_float = e->tag != TAG_PIXELS;
    w->file->encapsulated = e->length == UNDEFINED;
    w->file->pixel_offset = e->value;
    w->file->pixel_length = w->file->encapsulated ? w->length - e->value : e->length;
}

/* Elements from *at to `end`, or to the end mark of the item that they are in. */
static bool walk_elements(struct walk *w, uint64_t *at, uint64_t end, struct place place)
{
    struct element e;
    while (*at < end && !w->done) {
        if (!read_element(w, *at, &e))
            return false;
        *at = e.value;
        if (e.tag == TAG_ITEM_END)
            return place.depth > 0 ||
                   pel_fail(w->error, PEL_ERROR_FORMAT, "byte %llu: the end of an item that did not begin", (unsigned long long)*at - 8);
        if (e.length != UNDEFINED && (*at > end || e.length > end - *at))
            return ends_early(w, *at);
        if (place.depth == 0 && (e.tag == TAG_PIXELS || e.tag == TAG_FLOAT_PIXELS || e.tag == TAG_DOUBLE_PIXELS)) {
            take_pixels(w, &e);
            return true;
        }
        if (e.length == UNDEFINED || is_group(e.tag)) {
            bool outer = w->explicit_vr; /* inside of an unknown element of undefined length all is implicit (PS3.5, 6.2.2) */
            w->explicit_vr = outer && strcmp(e.vr, "UN");
            bool ok = walk_items(w, at, e.length == UNDEFINED ? end : *at + e.length, &e, place);
            w->explicit_vr = outer;
            if (!ok)
                return false;
        } else {
            take_element(w, &e, &place);
            *at += e.length;
        }
    }
    return true;
}

/* Adds a number to an array that doubles. */
static bool append(uint64_t **array, uint64_t *count, uint64_t value, struct pel_error *error)
{
    if ((*count & (*count - 1)) == 0) {
        size_t room = *count ? (size_t)*count * 2 : 1;
        uint64_t *grown = realloc(*array, room * sizeof *grown);
        if (!grown)
            return pel_fail(error, PEL_ERROR_MEMORY, "no memory for %zu fragments", room);
        *array = grown;
    }
    (*array)[(*count)++] = value;
    return true;
}

/* Where the fragments of encapsulated pixels stand: the first item is the offset table, perhaps an empty one. */
static bool find_fragments(struct walk *w)
{
    struct pel_dicom_file *f = w->file;
    struct element item;
    uint64_t at = f->pixel_offset, numbers = 0;
    for (bool first = true; at < w->length; first = false) {
        if (!read_element(w, at, &item))
            return false;
        at = item.value;
        if (item.tag == TAG_SEQUENCE_END)
            break;
        if (item.tag != TAG_ITEM || item.length > w->length - at)
            return pel_fail(w->error, PEL_ERROR_FORMAT, "the compressed pixels end too soon, at byte %llu", (unsigned long long)at - 8);
        for (uint64_t i = 0; first && i + 4 <= item.length; i += 4) {
            const unsigned char *p = look(w, at + i, 4);
            if (!p || !append(&f->table, &f->table_count, number32(w, p), w->error))
                return p ? false : ends_early(w, at);
        }
        if (!first && (!append(&f->fragments, &numbers, at, w->error) || !append(&f->fragments, &numbers, item.length, w->error)))
            return false;
        at += item.length;
    }
    f->fragment_count = numbers / 2;
    return true;
}

/* The group of elements in front of the data set, always little-endian and explicit. */
static bool walk_meta(struct walk *w, uint64_t *at)
{
    struct element e;
    const unsigned char *p;
    w->explicit_vr = true;
    while ((p = look(w, *at, 2)) && number16(w, p) == 2) {
        if (!read_element(w, *at, &e))
            return false;
        if (e.length == UNDEFINED || e.length > w->length - e.value)
            return ends_early(w, *at);
        if (e.tag == TAG_SYNTAX)
            take_text(w, &e, w->file->syntax, sizeof w->file->syntax);
        *at = e.value + e.length;
    }
    return true;
}

/* How the data set is written: what the transfer syntax says, held against the first element, for some files lie. */
static bool find_encoding(struct walk *w, uint64_t at)
{
    const char *syntax = w->file->syntax;
    const unsigned char *p = look(w, at, 6);
    if (!strcmp(syntax, "1.2.840.10008.1.2.1.99"))
        return pel_fail(w->error, PEL_ERROR_UNSUPPORTED, "deflated DICOM is not read; unpack it, for example with gdcmconv --raw");
    if (!strcmp(syntax, "1.2.840.113619.5.2"))
        return pel_fail(w->error, PEL_ERROR_UNSUPPORTED,
                        "GE's private transfer syntax is not read; convert it, for example with gdcmconv --raw");
    w->big_endian = w->file->big_endian = !strcmp(syntax, "1.2.840.10008.1.2.2");
    w->explicit_vr = p && p[4] >= 'A' && p[4] <= 'Z' && p[5] >= 'A' && p[5] <= 'Z';
    return true;
}

/* Whether the file begins as DICOM does, and where its elements begin. Old files have no preamble. */
static bool find_start(struct walk *w, uint64_t *at)
{
    const unsigned char *p = look(w, 128, 4);
    *at = 132;
    if (p && !memcmp(p, "DICM", 4))
        return true;
    *at = 0;
    p = look(w, 0, 8);
    return p && p[1] == 0 && (p[0] == 2 || p[0] == 8) && p[3] <= 0x10 && (p[4] >= 'A' ? p[5] >= 'A' : p[6] == 0 && p[7] == 0);
}

bool pel_dicom_file_open(struct pel_dicom_file *file, const char *path, bool *is_dicom, struct pel_error *error)
{
    uint64_t at = 0;
    bool ok = false;
    struct walk *w = pel_alloc(1, sizeof *w, "DICOM header", error);
    memset(file, 0, sizeof *file);
    file->frame_count = 1;
    file->pixels.samples = 1;
    file->shared.slope = 1;
    *is_dicom = false;
    if (!w || !(file->path = pel_strdup(path, error)))
        goto done;
    w->file = file;
    w->error = error;
    w->locale = newlocale(LC_ALL_MASK, "C", (locale_t)0);
    w->stream = fopen(path, "rbe");
    if (!w->stream || w->locale == (locale_t)0 || fseeko(w->stream, 0, SEEK_END) != 0) {
        pel_fail_errno(error, "cannot be opened");
        goto done;
    }
    w->length = (uint64_t)ftello(w->stream);
    *is_dicom = find_start(w, &at);
    ok = *is_dicom ? walk_meta(w, &at) && find_encoding(w, at) && walk_elements(w, &at, w->length, (struct place) { 0 })
                   : pel_fail(error, PEL_ERROR_FORMAT, "is no DICOM file");
    if (ok && file->encapsulated)
        ok = find_fragments(w);
done:
    if (w && w->stream)
        fclose(w->stream);
    if (w && w->locale != (locale_t)0)
        freelocale(w->locale);
    free(w);
    if (!ok)
        pel_dicom_file_finish(file);
    return ok;
}

void pel_dicom_file_finish(struct pel_dicom_file *file)
{
    free(file->path);
    free(file->frames);
    free(file->fragments);
    free(file->table);
    memset(file, 0, sizeof *file);
}

const struct pel_dicom_frame *pel_dicom_file_frame(const struct pel_dicom_file *file, uint64_t frame)
{
    return frame < file->described ? &file->frames[frame] : &file->shared;
}
