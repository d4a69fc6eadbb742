/* SPDX-License-Identifier: MIT */
/* What the axes of a NRRD mean. The format has any number of them and says more or less about each: a world direction ("space directions"),
 * a kind ("vector", "list", "domain"), a spacing that is nan where an axis is no distance. From this come the three axes of the volume, the
 * one of its components, and the others, of which the first sample is taken. */
#include <math.h>
#include <string.h>

#include "fail.h"
#include "nrrd.h"
#include "vec.h"

enum role { SPATIAL, COMPONENT, EXTRA };

static int type_of(int nrrd_type)
{
    switch (nrrd_type) {
    case nrrdTypeChar: return PEL_I8;
    case nrrdTypeUChar: return PEL_U8;
    case nrrdTypeShort: return PEL_I16;
    case nrrdTypeUShort: return PEL_U16;
    case nrrdTypeInt: return PEL_I32;
    case nrrdTypeUInt: return PEL_U32;
    case nrrdTypeLLong: return PEL_FILE_I64;
    case nrrdTypeULLong: return PEL_FILE_U64;
    case nrrdTypeFloat: return PEL_F32;
    case nrrdTypeDouble: return PEL_F64;
    default: return -1;
    }
}

/* An axis that has a direction in the world; time, the fourth world axis of some spaces, is none of it. */
static bool has_direction(const Nrrd *nrrd, unsigned axis)
{
    const double *v = nrrd->axis[axis].spaceDirection;
    bool any = false;
    for (unsigned i = 0; i < nrrd->spaceDim && i < 3; i++) {
        if (!isfinite(v[i]))
            return false;
        any = any || v[i] != 0;
    }
    return any;
}

/* What the file says of an axis, SPATIAL where it says nothing against it. */
static enum role said_role(const Nrrd *nrrd, unsigned axis, bool any_spacing)
{
    const NrrdAxisInfo *info = &nrrd->axis[axis];
    if (info->kind == nrrdKindTime || info->kind == nrrdKindList)
        return EXTRA;
    if (info->kind >= nrrdKindPoint && info->kind < nrrdKindLast)
        return COMPONENT;
    if (nrrd->spaceDim > 0)
        return has_direction(nrrd, axis) ? SPATIAL : COMPONENT;
    if (info->kind == nrrdKindDomain || info->kind == nrrdKindSpace)
        return SPATIAL;
    return any_spacing && !isfinite(info->spacing) && !isfinite(info->min) ? COMPONENT : SPATIAL;
}

static bool find_roles(const Nrrd *nrrd, enum role roles[8], struct pel_file_info *info, struct pel_error *error)
{
    bool any_spacing = false;
    int spatial = 0, components = 0;
    for (unsigned a = 0; a < nrrd->dim; a++)
        any_spacing = any_spacing || isfinite(nrrd->axis[a].spacing);
    for (unsigned a = 0; a < nrrd->dim; a++)
        roles[a] = said_role(nrrd, a, any_spacing);
    /* A list of a few numbers a sample (as many writers call RGB) is components; a long one is a list of volumes. */
    for (unsigned a = 0; a < nrrd->dim; a++) {
        if (roles[a] == EXTRA && nrrd->axis[a].kind == nrrdKindList && nrrd->axis[a].size <= 4)
            roles[a] = COMPONENT;
        if (roles[a] == COMPONENT && nrrd->axis[a].size == 1)
            roles[a] = EXTRA;
        spatial += roles[a] == SPATIAL;
    }
    /* More than three axes that nothing is said of: a short first one is components, those behind the third are other volumes. */
    for (unsigned a = 0; a < nrrd->dim && spatial > 3; a++)
        if (a == 0 && roles[a] == SPATIAL && nrrd->axis[a].size <= 4) {
            roles[a] = COMPONENT;
            spatial--;
            pel_info_note(info, "axis 0 with %zu samples is taken as the components of each sample", nrrd->axis[a].size);
        }
    for (unsigned a = nrrd->dim; a-- > 0 && spatial > 3;)
        if (roles[a] == SPATIAL) {
            roles[a] = EXTRA;
            spatial--;
        }
    for (unsigned a = 0; a < nrrd->dim; a++) {
        if (roles[a] == COMPONENT && components++)
            return pel_fail(error, PEL_ERROR_UNSUPPORTED, "has more than one axis of components (axis %u is another)", a);
        if (roles[a] == EXTRA && nrrd->axis[a].size > 1)
            pel_info_note(info, "axis %u has %zu volumes; the first is taken", a, nrrd->axis[a].size);
    }
    return spatial >= 2 || pel_fail(error, PEL_ERROR_UNSUPPORTED, "has %d spatial %s; a volume needs 3, an image 2", spatial,
                                    spatial == 1 ? "axis" : "axes");
}

/* Signs that turn the file's world into one of the three spaces that a volume may have. */
static enum pel_space to_known_space(int space, double sign[3], struct pel_file_info *info)
{
    sign[0] = sign[1] = sign[2] = 1;
    switch (space) {
    case nrrdSpaceRightAnteriorSuperior:
    case nrrdSpaceRightAnteriorSuperiorTime:
        return PEL_SPACE_RAS;
    case nrrdSpaceLeftPosteriorSuperior:
    case nrrdSpaceLeftPosteriorSuperiorTime:
        return PEL_SPACE_LPS;
    case nrrdSpaceLeftAnteriorSuperior:
    case nrrdSpaceLeftAnteriorSuperiorTime:
        sign[0] = -1;
        pel_info_note(info, "its world was left-anterior-superior; x is negated, and it is RAS now");
        return PEL_SPACE_RAS;
    case nrrdSpace3DLeftHanded:
    case nrrdSpace3DLeftHandedTime:
        sign[2] = -1;
        pel_info_note(info, "its world was left-handed; z is negated");
        return PEL_SPACE_UNKNOWN;
    case nrrdSpaceRightDown:
        sign[1] = -1;
        return PEL_SPACE_UNKNOWN;
    default:
        return PEL_SPACE_UNKNOWN;
    }
}

static void place_axes(const Nrrd *nrrd, const int axes[3], const double sign[3], struct pel_volume *volume, struct pel_file_info *info)
{
    int missing = -1;
    for (int i = 0; i < 3; i++) {
        double step[3] = { 0, 0, 0 };
        if (axes[i] < 0) {
            missing = i;
            step[i] = 1;
        } else if (nrrd->spaceDim > 0) {
            for (unsigned d = 0; d < nrrd->spaceDim && d < 3; d++)
                step[d] = nrrd->axis[axes[i]].spaceDirection[d] * sign[d];
        } else {
            double spacing, vector[NRRD_SPACE_DIM_MAX];
            int status = nrrdSpacingCalculate(nrrd, (unsigned)axes[i], &spacing, vector);
            step[i] = status == nrrdSpacingStatusScalarNoSpace ? spacing : 1;
        }
        pel_volume_set_axis(volume, i, step, info);
    }
    if (missing < 0 || nrrd->spaceDim < 3)
        return;
    /* An image in space: its missing axis stands upright on it. */
    double normal[3];
    pel_cross(volume->direction[0], volume->direction[1], normal);
    if (pel_normalize(normal) > 0)
        memcpy(volume->direction[2], normal, sizeof normal);
}

static void place_origin(const Nrrd *nrrd, const int axes[3], const double sign[3], struct pel_volume *volume)
{
    for (int i = 0; i < 3; i++) {
        double at = 0;
        if (nrrd->spaceDim > 0) {
            at = (unsigned)i < nrrd->spaceDim ? nrrd->spaceOrigin[i] * sign[i] : 0;
        } else if (axes[i] >= 0 && isfinite(nrrd->axis[axes[i]].min)) {
            const NrrdAxisInfo *axis = &nrrd->axis[axes[i]];
            /* Cells, Teem's own default, have their samples half a spacing within their ends. */
            at = axis->min + (axis->center == nrrdCenterNode ? 0 : volume->spacing[i] / 2 * volume->direction[i][i]);
        }
        volume->origin[i] = isfinite(at) ? at : 0;
    }
}

/* The exact placement that this library wrote beside the directions is taken where it agrees with them: direction times spacing, as the
 * format has it, does not always give back the two to the last bit. */
static void take_exact_placement(const struct pel_nrrd *head, const double sign[3], struct pel_volume *volume)
{
    if (!head->has_placement)
        return;
    for (int a = 0; a < 3; a++)
        for (int i = 0; i < 3; i++) {
            double is = volume->direction[a][i] * volume->spacing[a], noted = head->direction[a][i] * head->spacing[a] * sign[i];
            if (!(fabs(is - noted) <= 1e-12 * volume->spacing[a]))
                return;
        }
    memcpy(volume->spacing, head->spacing, sizeof volume->spacing);
    for (int a = 0; a < 3; a++)
        for (int i = 0; i < 3; i++)
            volume->direction[a][i] = head->direction[a][i] * sign[i];
}

static void take_words(const struct pel_nrrd *head, const int axes[3], struct pel_volume *volume, struct pel_file_info *info)
{
    const Nrrd *nrrd = head->nrrd;
    char units[64];
    pel_nrrd_quoted(nrrd->spaceDim > 0 ? head->space_units : head->units, nrrd->spaceDim > 0 ? 0 : axes[0], units, sizeof units);
    pel_copy_text(volume->units, sizeof volume->units, units);
    pel_copy_text(volume->name, sizeof volume->name, nrrd->content);
    volume->has_void = head->has_void;
    volume->void_value = head->void_value;
    if (nrrd->spaceDim != 3 || !isfinite(nrrd->measurementFrame[0][0]))
        return;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            if (nrrd->measurementFrame[i][j] != (i == j)) {
                pel_info_note(info, "vectors are given in a measurement frame of their own; they are taken as they stand");
                return;
            }
}

bool pel_nrrd_interpret(const struct pel_nrrd *head, struct pel_layout *layout, struct pel_volume *volume, struct pel_file_info *info,
                        struct pel_error *error)
{
    const Nrrd *nrrd = head->nrrd;
    enum role roles[8];
    if (nrrd->dim < 2 || nrrd->dim > 8)
        return pel_fail(error, PEL_ERROR_UNSUPPORTED, "has %u axes; 2 to 8 can be read", nrrd->dim);
    *layout = (struct pel_layout){ .axis_count = (int)nrrd->dim, .component_axis = -1, .axes = { -1, -1, -1 }, .type = type_of(nrrd->type),
                                   .big_endian = PEL_HOST_BIG_ENDIAN };
    if (layout->type < 0)
        return pel_fail(error, PEL_ERROR_UNSUPPORTED, "has samples of type \"block\", which have no value");
    if (head->nio->encoding->endianMatters && pel_type_size(pel_file_type_in_memory(layout->type)) > 1)
        layout->big_endian = head->nio->endian == airEndianBig;
    if (!find_roles(nrrd, roles, info, error))
        return false;
    int spatial = 0;
    for (unsigned a = 0; a < nrrd->dim; a++) {
        layout->sizes[a] = nrrd->axis[a].size;
        if (roles[a] == SPATIAL)
            layout->axes[spatial++] = (int)a;
        else if (roles[a] == COMPONENT)
            layout->component_axis = (int)a;
    }
    double sign[3];
    volume->space = to_known_space(nrrd->space, sign, info);
    place_axes(nrrd, layout->axes, sign, volume, info);
    take_exact_placement(head, sign, volume);
    pel_volume_mend_directions(volume, info);
    place_origin(nrrd, layout->axes, sign, volume);
    take_words(head, layout->axes, volume, info);
    pel_layout_note(layout, info);
    return true;
}

/* Kinds whose numbers are lengths along the world's axes. A float 3-vector of which nothing is said is one. */
static bool holds_world_vectors(const struct pel_nrrd *head, const struct pel_layout *layout, const struct pel_volume *volume)
{
    int kind = layout->component_axis < 0 ? nrrdKindScalar : head->nrrd->axis[layout->component_axis].kind;
    return volume->components == 3 && (volume->type == PEL_F32 || volume->type == PEL_F64) &&
           (kind == nrrdKindUnknown || kind == nrrdKindVector || kind == nrrdKindCovariantVector || kind == nrrdKindNormal ||
            kind == nrrdKind3Vector || kind == nrrdKind3Gradient || kind == nrrdKind3Normal);
}

void pel_nrrd_turn_vectors(const struct pel_nrrd *head, const struct pel_layout *layout, struct pel_volume *volume)
{
    double sign[3];
    to_known_space(head->nrrd->space, sign, NULL);
    if (!holds_world_vectors(head, layout, volume))
        return;
    size_t count = pel_volume_samples(volume);
    for (int c = 0; c < 3; c++)
        for (size_t i = 0; sign[c] < 0 && i < count; i++) {
            if (volume->type == PEL_F32)
                ((float *)volume->data)[3 * i + (size_t)c] *= -1;
            else
                ((double *)volume->data)[3 * i + (size_t)c] *= -1;
        }
}
