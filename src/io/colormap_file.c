/* SPDX-License-Identifier: MIT */
/* ParaView's colour maps, JSON (a list of presets, or one) and XML (<ColorMap> with <Point>s, alone or in <ColorMaps>), become the same
 * preset: flat lists of points and a colour space. What interpolates in another space than RGB, or bends between opacity points, is
 * resampled into straight pieces. */

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include <expat.h>

#include <pellucid/io.h>

#include "alloc.h"
#include "c_locale.h"
#include "color_space.h"
#include "fail.h"
#include "json_file.h"

enum { MOST_POINTS = 8192, PIECES = 16 };

struct list {
    double *values; /* owned */
    size_t count, room;
};

struct preset {
    char name[64];
    enum pel_color_space space;
    bool wrap;
    struct list colors;    /* x r g b ... */
    struct list opacities; /* x opacity midpoint sharpness ... */
    struct list indexed;   /* r g b ..., for maps of categories */
};

static void preset_finish(struct preset *preset)
{
    free(preset->colors.values);
    free(preset->opacities.values);
    free(preset->indexed.values);
}

static bool append(struct list *list, const double *values, size_t count, struct pel_error *error)
{
    if (list->count + count > 4 * MOST_POINTS)
        return pel_fail(error, PEL_ERROR_FORMAT, "more than %d points", MOST_POINTS);
    if (list->count + count > list->room) {
        size_t room = list->room ? 2 * list->room : 256;
        double *larger = realloc(list->values, room * sizeof *larger);
        if (!larger)
            return pel_fail(error, PEL_ERROR_MEMORY, "no memory for %zu numbers", room);
        list->values = larger;
        list->room = room;
    }
    memcpy(list->values + list->count, values, count * sizeof *values);
    list->count += count;
    return true;
}

static void copy_name(char out[64], const char *name)
{
    snprintf(out, 64, "%s", name);
    if (strlen(name) < 64)
        return;
    size_t n = 63;
    while (n > 0 && ((unsigned char)name[n] & 0xc0) == 0x80) /* cut between UTF-8 characters */
        n--;
    out[n] = 0;
}

static enum pel_color_space space_of(const char *name)
{
    static const struct {
        const char *name;
        enum pel_color_space space;
    } spaces[] = {
        { "RGB", PEL_COLOR_SPACE_RGB },
        { "HSV", PEL_COLOR_SPACE_HSV },
        { "Lab", PEL_COLOR_SPACE_LAB },
        { "CIELAB", PEL_COLOR_SPACE_LAB },
        { "Diverging", PEL_COLOR_SPACE_DIVERGING },
        { "Step", PEL_COLOR_SPACE_STEP },
        { "Lab/CIEDE2000", PEL_COLOR_SPACE_LAB },
        { "CIEDE2000", PEL_COLOR_SPACE_LAB },
    };
    for (size_t i = 0; i < sizeof spaces / sizeof *spaces; i++)
        if (strcasecmp(name, spaces[i].name) == 0)
            return spaces[i].space;
    return PEL_COLOR_SPACE_RGB;
}

/* ---- preset to transfer function ---- */

/* Where a point of the file goes. */
struct stretch {
    double from, scale, to;
};

static double stretched(const struct stretch *s, double x)
{
    return s->to + (x - s->from) * s->scale;
}

static bool all_finite(const struct list *list)
{
    for (size_t i = 0; i < list->count; i++)
        if (!isfinite(list->values[i]))
            return false;
    return true;
}

static bool is_sorted(const struct list *list, size_t stride)
{
    for (size_t i = stride; i < list->count; i += stride)
        if (!(list->values[i] >= list->values[i - stride]))
            return false;
    return true;
}

/* Points of a jumpless RGB curve through the preset's colours. Returns their number; `out` has room for PIECES points a segment and one. */
static size_t color_points(const struct preset *p, const struct stretch *s, struct pel_color_point *out)
{
    size_t points = p->colors.count / 4, n = 0;
    int pieces = p->space == PEL_COLOR_SPACE_RGB ? 1 : p->space == PEL_COLOR_SPACE_STEP ? 2 : points > 64 ? 4 : PIECES;
    for (size_t i = 0; i < points; i++) {
        const double *a = p->colors.values + 4 * i, *b = a + 4;
        out[n++] = (struct pel_color_point) { stretched(s, a[0]), { a[1], a[2], a[3] } };
        if (i + 1 == points || a[0] == b[0])
            continue;
        for (int k = 1; k < pieces; k++, n++) {
            double t = p->space == PEL_COLOR_SPACE_STEP ? 1 : (double)k / pieces; /* a step's first colour holds until the next point */
            out[n].value = stretched(s, a[0] * (1 - t) + b[0] * t);
            pel_color_between(p->space, p->wrap, a + 1, b + 1, p->space == PEL_COLOR_SPACE_STEP ? 0 : t, out[n].rgb);
        }
    }
    return n;
}

/* Equal parts of [0, 1], one a colour. */
static size_t indexed_points(const struct preset *p, const struct stretch *s, struct pel_color_point *out)
{
    size_t colors = p->indexed.count / 3;
    for (size_t i = 0; i < 2 * colors; i++) {
        const double *rgb = p->indexed.values + 3 * (i / 2);
        out[i] = (struct pel_color_point) { stretched(s, (double)((i + 1) / 2) / (double)colors), { rgb[0], rgb[1], rgb[2] } };
    }
    return 2 * colors;
}

/* VTK's curve between two opacity points: the midpoint says where half way is, the sharpness how abrupt. */
static double bent(double a, double b, double t, double midpoint, double sharpness)
{
    t = t < midpoint ? 0.5 * t / midpoint : 0.5 + 0.5 * (t - midpoint) / (1 - midpoint);
    if (sharpness < 0.01)
        return a * (1 - t) + b * t;
    t = t < 0.5 ? 0.5 * pow(2 * t, 1 + 10 * sharpness) : 1 - 0.5 * pow(2 - 2 * t, 1 + 10 * sharpness);
    double slope = (1 - sharpness) * (b - a), t2 = t * t, t3 = t2 * t;
    double value = a + (b - a) * (3 * t2 - 2 * t3) + slope * (2 * t3 - 3 * t2 + t);
    return fmin(fmax(value, fmin(a, b)), fmax(a, b));
}

static size_t opacity_points(const struct preset *p, const struct stretch *s, struct pel_opacity_point *out)
{
    size_t points = p->opacities.count / 4, n = 0;
    for (size_t i = 0; i < points; i++) {
        const double *a = p->opacities.values + 4 * i, *b = a + 4;
        out[n++] = (struct pel_opacity_point) { stretched(s, a[0]), a[1] };
        if (i + 1 == points || a[0] == b[0])
            continue;
        double middle = fmin(fmax(a[2], 0.00001), 0.99999), at = a[0] * (1 - middle) + b[0] * middle;
        if (a[3] > 0.99) {
            out[n++] = (struct pel_opacity_point) { stretched(s, at), a[1] };
            out[n++] = (struct pel_opacity_point) { stretched(s, at), b[1] };
        } else if (a[3] >= 0.01) {
            for (int k = 1; k < PIECES; k++) {
                double t = (double)k / PIECES;
                out[n++] = (struct pel_opacity_point) { stretched(s, a[0] * (1 - t) + b[0] * t), bent(a[1], b[1], t, middle, a[3]) };
            }
        } else if (fabs(middle - 0.5) > 1e-6) {
            out[n++] = (struct pel_opacity_point) { stretched(s, at), (a[1] + b[1]) / 2 };
        }
    }
    return n;
}

/* Normalised maps (0 to 1) stretch over lo..hi; others hold data values already. */
static struct stretch choose_stretch(const struct preset *p, double lo, double hi)
{
    const struct list *c = &p->colors;
    bool normalised = c->count ? c->values[0] == 0 && c->values[c->count - 4] == 1 : true;
    if (!normalised || !isfinite(lo) || !isfinite(hi))
        return (struct stretch) { 0, 1, 0 };
    return (struct stretch) { 0, hi - lo, lo };
}

static bool check_preset(const struct preset *p, struct pel_error *error)
{
    if (!p->colors.count && !p->indexed.count)
        return pel_fail(error, PEL_ERROR_FORMAT, "color map '%s' has no colors", p->name);
    if (p->colors.count % 4 || p->opacities.count % 4 || p->indexed.count % 3)
        return pel_fail(error, PEL_ERROR_FORMAT, "color map '%s': %s", p->name,
                        p->colors.count % 4      ? "RGBPoints are not groups of four (value, red, green, blue)"
                        : p->opacities.count % 4 ? "Points are not groups of four (value, opacity, midpoint, sharpness)"
                                                 : "IndexedColors are not groups of three");
    if (!all_finite(&p->colors) || !all_finite(&p->opacities) || !all_finite(&p->indexed))
        return pel_fail(error, PEL_ERROR_FORMAT, "color map '%s': a number is not finite", p->name);
    if (!is_sorted(&p->colors, 4) || !is_sorted(&p->opacities, 4))
        return pel_fail(error, PEL_ERROR_FORMAT, "color map '%s': the points' values do not rise", p->name);
    return true;
}

/* Opacity 1 at every point is what XML maps say that have none to tell. */
static bool tells_opacity(const struct preset *p)
{
    for (size_t i = 1; i < p->opacities.count; i += 4)
        if (p->opacities.values[i] != 1)
            return true;
    return false;
}

static bool apply(const struct preset *p, double lo, double hi, struct pel_transfer *transfer, struct pel_error *error)
{
    if (!check_preset(p, error))
        return false;
    struct stretch s = choose_stretch(p, lo, hi);
    size_t room = (p->colors.count / 4 + p->indexed.count + p->opacities.count / 4 + 1) * PIECES;
    struct pel_color_point *colors = pel_alloc(room, sizeof *colors, "color curve", error);
    struct pel_opacity_point *opacities = pel_alloc(room, sizeof *opacities, "opacity curve", error);
    struct pel_transfer next = { 0 };
    bool ok = colors && opacities && pel_transfer_copy(&next, transfer, error);
    if (ok) {
        size_t n = p->colors.count ? color_points(p, &s, colors) : indexed_points(p, &s, colors);
        ok = pel_transfer_set_colors(&next, colors, n, error) &&
             (!tells_opacity(p) || pel_transfer_set_opacities(&next, opacities, opacity_points(p, &s, opacities), error));
        if (!ok && error && error->code == PEL_ERROR_ARGUMENT) /* the file's fault, not the caller's */
            error->code = PEL_ERROR_FORMAT;
    }
    if (ok) {
        memcpy(next.colormap, p->name, sizeof next.colormap);
        struct pel_transfer old = *transfer;
        *transfer = next;
        next = old;
    }
    pel_transfer_finish(&next);
    free(colors);
    free(opacities);
    return ok;
}

/* ---- JSON ---- */

static bool read_list(const json_t *object, const char *key, struct list *list, struct pel_error *error)
{
    const json_t *array = json_object_get(object, key);
    if (!array || json_is_null(array))
        return true;
    if (!json_is_array(array))
        return pel_fail(error, PEL_ERROR_FORMAT, "%s: expected an array, found %s", key, pel_json_kind(array));
    for (size_t i = 0; i < json_array_size(array); i++) {
        double value;
        if (!pel_json_number(json_array_get(array, i), &value, error))
            return pel_fail_in(error, "%s: entry %zu: ", key, i + 1);
        if (!append(list, &value, 1, error))
            return pel_fail_in(error, "%s: ", key);
    }
    return true;
}

static bool read_json_preset(const json_t *object, struct preset *preset, struct pel_error *error)
{
    const char *name = json_string_value(json_object_get(object, "Name"));
    const char *space = json_string_value(json_object_get(object, "ColorSpace"));
    copy_name(preset->name, name ? name : "");
    preset->space = space_of(space ? space : "RGB");
    const json_t *wrap = json_object_get(object, "HSVWrap");
    preset->wrap = json_is_true(wrap) || json_number_value(wrap) != 0;
    return read_list(object, "RGBPoints", &preset->colors, error) && read_list(object, "Points", &preset->opacities, error) &&
           read_list(object, "IndexedColors", &preset->indexed, error);
}

/* The preset of that name, or the first. */
static const json_t *find_json_preset(const json_t *root, const char *name)
{
    size_t count = json_is_array(root) ? json_array_size(root) : 1;
    for (size_t i = 0; i < count; i++) {
        const json_t *object = json_is_array(root) ? json_array_get(root, i) : root;
        const char *found = json_string_value(json_object_get(object, "Name"));
        if (json_is_object(object) && (!name || (found && strcmp(found, name) == 0)))
            return object;
    }
    return NULL;
}

static bool parse_json(const char *text, size_t size, const char *name, struct preset *preset, struct pel_error *error)
{
    json_t *root = pel_json_parse(text, size, error);
    if (!root)
        return false;
    const json_t *object = find_json_preset(root, name);
    bool ok = object ? read_json_preset(object, preset, error)
              : name ? pel_fail(error, PEL_ERROR_ARGUMENT, "there is no color map '%s' in it", name)
                     : pel_fail(error, PEL_ERROR_FORMAT, "there is no color map in it");
    json_decref(root);
    return ok;
}

/* ---- XML ---- */

struct xml_reader {
    XML_Parser parser;
    const char *name; /* wanted, or NULL */
    struct preset *preset;
    struct pel_error *error;
    bool inside, found, failed;
};

static double number_of(const char *text)
{
    char *end;
    double value = strtod(text, &end);
    return end == text || *end ? NAN : value;
}

static void xml_fail(struct xml_reader *r)
{
    r->failed = true;
    XML_StopParser(r->parser, XML_FALSE);
}

static void xml_map(struct xml_reader *r, const char **attributes)
{
    const char *name = "", *space = "RGB";
    for (; *attributes; attributes += 2) {
        if (strcmp(attributes[0], "name") == 0)
            name = attributes[1];
        else if (strcmp(attributes[0], "space") == 0)
            space = attributes[1];
    }
    r->inside = !r->found && (!r->name || strcmp(name, r->name) == 0);
    if (!r->inside)
        return;
    r->found = true;
    copy_name(r->preset->name, name);
    r->preset->space = space_of(space);
    r->preset->wrap = true;
}

static void xml_point(struct xml_reader *r, const char **attributes)
{
    double color[4] = { NAN, NAN, NAN, NAN }, opacity[4] = { NAN, NAN, 0.5, 0 };
    bool has_opacity = false;
    for (; *attributes; attributes += 2) {
        static const char keys[] = "xrgb";
        const char *key = attributes[0][0] && !attributes[0][1] ? strchr(keys, attributes[0][0]) : NULL;
        if (key) {
            color[key - keys] = number_of(attributes[1]);
        } else if (strcmp(attributes[0], "o") == 0) {
            opacity[1] = number_of(attributes[1]);
            has_opacity = true;
        }
    }
    opacity[0] = color[0];
    for (int i = 0; i < 4; i++)
        if (!isfinite(color[i]) || (has_opacity && !isfinite(opacity[i]))) {
            pel_fail(r->error, PEL_ERROR_FORMAT, "line %lu: a point needs the numbers x, r, g and b",
                     (unsigned long)XML_GetCurrentLineNumber(r->parser));
            xml_fail(r);
            return;
        }
    if (!append(&r->preset->colors, color, 4, r->error) || (has_opacity && !append(&r->preset->opacities, opacity, 4, r->error)))
        xml_fail(r);
}

static void XMLCALL xml_start(void *user, const char *element, const char **attributes)
{
    struct xml_reader *r = user;
    if (r->failed)
        return;
    if (strcmp(element, "ColorMap") == 0)
        xml_map(r, attributes);
    else if (strcmp(element, "Point") == 0 && r->inside)
        xml_point(r, attributes);
}

static void XMLCALL xml_end(void *user, const char *element)
{
    struct xml_reader *r = user;
    if (strcmp(element, "ColorMap") == 0)
        r->inside = false;
}

/* A colour map has no use for entities, and they are what XML bombs are made of. */
static void XMLCALL xml_doctype(void *user, const char *name, const char *system, const char *public, int has_internal)
{
    (void)name, (void)system, (void)public;
    struct xml_reader *r = user;
    if (has_internal) {
        pel_fail(r->error, PEL_ERROR_UNSUPPORTED, "an XML document type with declarations is not read");
        xml_fail(r);
    }
}

static bool parse_xml(const char *text, size_t size, const char *name, struct preset *preset, struct pel_error *error)
{
    struct xml_reader r = { XML_ParserCreate(NULL), name, preset, error, false, false, false };
    if (!r.parser)
        return pel_fail(error, PEL_ERROR_MEMORY, "no memory for an XML parser");
    XML_SetUserData(r.parser, &r);
    XML_SetElementHandler(r.parser, xml_start, xml_end);
    XML_SetStartDoctypeDeclHandler(r.parser, xml_doctype);
    bool ok = XML_Parse(r.parser, text, (int)size, 1) == XML_STATUS_OK;
    if (r.failed)
        ok = false;
    else if (!ok)
        pel_fail(error, PEL_ERROR_FORMAT, "line %lu: %s", (unsigned long)XML_GetCurrentLineNumber(r.parser),
                 XML_ErrorString(XML_GetErrorCode(r.parser)));
    else if (!r.found)
        ok = name ? pel_fail(error, PEL_ERROR_ARGUMENT, "there is no color map '%s' in it", name)
                  : pel_fail(error, PEL_ERROR_FORMAT, "there is no color map in it");
    XML_ParserFree(r.parser);
    return ok;
}

/* ---- */

bool pel_transfer_from_text(const char *text, size_t size, const char *name, double lo, double hi, struct pel_transfer *transfer,
                            struct pel_error *error)
{
    struct preset preset = { .name = "" };
    size_t at = size >= 3 && memcmp(text, "\xef\xbb\xbf", 3) == 0 ? 3 : 0; /* a byte order mark */
    while (at < size && isspace((unsigned char)text[at]))
        at++;
    bool xml = at < size && text[at] == '<';
    const struct pel_c_locale locale = pel_c_locale_begin();
    bool ok = (xml ? parse_xml : parse_json)(text + at, size - at, name, &preset, error) && apply(&preset, lo, hi, transfer, error);
    pel_c_locale_end(&locale);
    preset_finish(&preset);
    return ok;
}

bool pel_read_transfer(const char *path, const char *name, double lo, double hi, struct pel_transfer *transfer, struct pel_error *error)
{
    size_t size;
    char *text = pel_text_file_read(path, &size, error);
    bool ok = text && pel_transfer_from_text(text, size, name, lo, hi, transfer, error);
    free(text);
    return ok || pel_fail_in(error, "%s: ", path);
}

static json_t *numbers(const double *values, size_t count)
{
    json_t *array = json_array();
    for (size_t i = 0; array && i < count; i++)
        json_array_append_new(array, json_real(values[i]));
    return array;
}

/* A list of one preset, to be decref'd; NULL on failure. */
static json_t *to_json(const struct pel_transfer *transfer, struct pel_error *error)
{
    json_t *preset = json_object(), *root = json_array(), *colors = json_array(), *opacities = json_array();
    for (size_t i = 0; i < transfer->color_count; i++) {
        const struct pel_color_point *p = &transfer->colors[i];
        json_t *group = numbers((double[]) { p->value, p->rgb[0], p->rgb[1], p->rgb[2] }, 4);
        json_array_extend(colors, group);
        json_decref(group);
    }
    for (size_t i = 0; i < transfer->opacity_count; i++) {
        json_t *group = numbers((double[]) { transfer->opacities[i].value, transfer->opacities[i].opacity, 0.5, 0 }, 4);
        json_array_extend(opacities, group);
        json_decref(group);
    }
    json_object_set_new(preset, "ColorSpace", json_string("RGB"));
    json_object_set_new(preset, "Name", json_string(transfer->colormap[0] ? transfer->colormap : "pellucid"));
    json_object_set_new(preset, "Points", opacities);
    json_object_set_new(preset, "RGBPoints", colors);
    json_array_append_new(root, preset);
    bool complete = json_array_size(colors) == 4 * transfer->color_count && json_array_size(opacities) == 4 * transfer->opacity_count &&
                    json_object_size(preset) == 4;
    if (complete)
        return root;
    json_decref(root);
    pel_fail(error, PEL_ERROR_ARGUMENT, "a number is not finite, the name is not UTF-8, or memory ran out");
    return NULL;
}

bool pel_write_transfer(const char *path, const struct pel_transfer *transfer, struct pel_error *error)
{
    json_t *root = to_json(transfer, error);
    bool ok = root && pel_json_write(path, root, error);
    json_decref(root);
    return ok || pel_fail_in(error, "%s: ", path);
}

char *pel_transfer_to_text(const struct pel_transfer *transfer, struct pel_error *error)
{
    json_t *root = to_json(transfer, error);
    char *text = root ? pel_json_to_text(root, error) : NULL;
    json_decref(root);
    return text;
}
