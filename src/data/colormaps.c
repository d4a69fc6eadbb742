/* SPDX-License-Identifier: MIT */
/* Named colour maps as few points with straight lines between them: what a transfer function is made of anyway, so that a stretched map can
 * be edited point by point and takes no code of its own. The points of the published 256-entry maps were chosen as the fewest that keep
 * every entry within 0.004 (one step of an 8-bit picture). Sources: viridis, plasma, inferno, magma (Smith, van der Walt, Firing; CC0),
 * cividis (Nunez, Anderton, Renslow, PLoS ONE 2018), turbo (Mikhailov, Google, 2019), coolwarm (computed in Msh space as in Moreland,
 * "Diverging Color Maps for Scientific Visualization", 2009), bone, hot, copper and jet (their usual piecewise linear definitions), ct
 * (ours: flesh to bone). */
#include "colormaps.h"

#include <ctype.h>
#include <string.h>
#include <strings.h>

#include <pellucid/transfer.h>

#include "fail.h"

/* clang-format off */
static const struct pel_colormap_point viridis[] = {
    { 0, { 0.267, 0.0049, 0.3294 } }, { 0.0784, { 0.2832, 0.1157, 0.4361 } }, { 0.149, { 0.273, 0.2045, 0.5017 } },
    { 0.2235, { 0.2431, 0.2921, 0.5385 } }, { 0.3451, { 0.1856, 0.4186, 0.5568 } }, { 0.498, { 0.1287, 0.5633, 0.5512 } },
    { 0.5647, { 0.1206, 0.6258, 0.5335 } }, { 0.6118, { 0.1433, 0.6695, 0.5112 } }, { 0.6588, { 0.1966, 0.7118, 0.4792 } },
    { 0.7176, { 0.2965, 0.7616, 0.4242 } }, { 0.7882, { 0.4494, 0.8138, 0.3354 } }, { 0.8824, { 0.6889, 0.8654, 0.1827 } },
    { 0.9294, { 0.8146, 0.8834, 0.1103 } }, { 0.9529, { 0.8762, 0.8911, 0.0953 } }, { 0.9765, { 0.9359, 0.8986, 0.1081 } },
    { 1, { 0.9932, 0.9062, 0.1439 } },
};
static const struct pel_colormap_point plasma[] = {
    { 0, { 0.0504, 0.0298, 0.528 } }, { 0.0235, { 0.1151, 0.0236, 0.5555 } }, { 0.0824, { 0.228, 0.016, 0.6049 } },
    { 0.1686, { 0.3687, 0.0027, 0.6506 } }, { 0.2353, { 0.4715, 0.0057, 0.6599 } }, { 0.2824, { 0.5406, 0.035, 0.6486 } },
    { 0.3569, { 0.641, 0.1165, 0.6021 } }, { 0.4706, { 0.7681, 0.2448, 0.4985 } }, { 0.6078, { 0.8874, 0.4018, 0.3765 } },
    { 0.7255, { 0.9613, 0.5486, 0.2753 } }, { 0.8196, { 0.992, 0.6812, 0.1953 } }, { 0.8902, { 0.9912, 0.7905, 0.1494 } },
    { 0.9176, { 0.984, 0.8353, 0.1425 } }, { 0.9882, { 0.9466, 0.9552, 0.1503 } }, { 1, { 0.94, 0.9752, 0.1313 } },
};
static const struct pel_colormap_point inferno[] = {
    { 0, { 0.0015, 0.0005, 0.0139 } }, { 0.0235, { 0.0096, 0.0077, 0.0551 } }, { 0.0627, { 0.0423, 0.0281, 0.1411 } },
    { 0.1137, { 0.1105, 0.0474, 0.2629 } }, { 0.1569, { 0.1834, 0.0403, 0.355 } }, { 0.1922, { 0.245, 0.0371, 0.4 } },
    { 0.2431, { 0.3289, 0.0578, 0.4275 } }, { 0.3176, { 0.4474, 0.1016, 0.4311 } }, { 0.4, { 0.5783, 0.148, 0.4044 } },
    { 0.4863, { 0.7124, 0.2037, 0.3444 } }, { 0.5686, { 0.8274, 0.2795, 0.2617 } }, { 0.6471, { 0.913, 0.3816, 0.1698 } },
    { 0.7216, { 0.9654, 0.5022, 0.0739 } }, { 0.7608, { 0.9808, 0.5722, 0.0285 } }, { 0.7843, { 0.986, 0.6158, 0.0256 } },
    { 0.8078, { 0.9879, 0.6603, 0.0517 } }, { 0.8549, { 0.9822, 0.7514, 0.1476 } }, { 0.898, { 0.9662, 0.8362, 0.2615 } },
    { 0.9333, { 0.95, 0.9034, 0.3803 } }, { 0.9647, { 0.9495, 0.9551, 0.5079 } }, { 0.9922, { 0.9765, 0.9898, 0.6168 } },
    { 1, { 0.9884, 0.9984, 0.6449 } },
};
static const struct pel_colormap_point magma[] = {
    { 0, { 0.0015, 0.0005, 0.0139 } }, { 0.0275, { 0.0115, 0.0098, 0.0607 } }, { 0.0745, { 0.0523, 0.0394, 0.1588 } },
    { 0.1333, { 0.1238, 0.0673, 0.2959 } }, { 0.1843, { 0.2049, 0.0629, 0.4115 } }, { 0.2196, { 0.2654, 0.0602, 0.4618 } },
    { 0.2667, { 0.3415, 0.0806, 0.4926 } }, { 0.3529, { 0.4758, 0.1346, 0.5079 } }, { 0.451, { 0.6328, 0.1879, 0.4953 } },
    { 0.5373, { 0.7737, 0.2362, 0.4553 } }, { 0.6078, { 0.8795, 0.2961, 0.4031 } }, { 0.6627, { 0.9407, 0.3712, 0.3668 } },
    { 0.7098, { 0.9716, 0.4542, 0.361 } }, { 0.7608, { 0.9885, 0.5504, 0.3884 } }, { 0.8235, { 0.9966, 0.6683, 0.4562 } },
    { 0.9059, { 0.9954, 0.8199, 0.5791 } }, { 1, { 0.9871, 0.9914, 0.7495 } },
};
static const struct pel_colormap_point cividis[] = {
    { 0, { 0, 0.1351, 0.3048 } }, { 0.0784, { 0, 0.1888, 0.4396 } }, { 0.0902, { 0.0036, 0.1959, 0.4416 } },
    { 0.1098, { 0.069, 0.2094, 0.4389 } }, { 0.1412, { 0.1307, 0.2315, 0.4328 } }, { 0.2078, { 0.2179, 0.278, 0.4242 } },
    { 0.349, { 0.3564, 0.3759, 0.4308 } }, { 0.5216, { 0.5069, 0.4997, 0.4724 } }, { 0.6431, { 0.6247, 0.592, 0.4606 } },
    { 0.7608, { 0.7447, 0.6872, 0.4204 } }, { 0.8588, { 0.8492, 0.7719, 0.3597 } }, { 0.9294, { 0.9277, 0.8365, 0.2906 } },
    { 0.9882, { 0.9948, 0.893, 0.2034 } }, { 1, { 0.9957, 0.9093, 0.2178 } },
};
static const struct pel_colormap_point turbo[] = {
    { 0, { 0.19, 0.0718, 0.2322 } }, { 0.0275, { 0.2211, 0.1522, 0.4256 } }, { 0.0549, { 0.2454, 0.2304, 0.5914 } },
    { 0.0824, { 0.2628, 0.3064, 0.7297 } }, { 0.1098, { 0.2733, 0.3801, 0.8404 } }, { 0.1373, { 0.277, 0.4515, 0.9235 } },
    { 0.1647, { 0.2738, 0.5207, 0.979 } }, { 0.1843, { 0.2625, 0.5697, 0.9977 } }, { 0.2078, { 0.2329, 0.6292, 0.992 } },
    { 0.2353, { 0.1862, 0.6977, 0.955 } }, { 0.2745, { 0.1215, 0.789, 0.8658 } }, { 0.302, { 0.0953, 0.8446, 0.793 } },
    { 0.3255, { 0.0966, 0.8845, 0.7332 } }, { 0.349, { 0.1273, 0.917, 0.6763 } }, { 0.3765, { 0.1966, 0.949, 0.5947 } },
    { 0.4118, { 0.3201, 0.9797, 0.4765 } }, { 0.4588, { 0.5036, 0.9988, 0.327 } }, { 0.4902, { 0.6109, 0.9951, 0.2528 } },
    { 0.5176, { 0.6849, 0.9794, 0.216 } }, { 0.5529, { 0.7759, 0.9411, 0.2031 } }, { 0.6039, { 0.8911, 0.8583, 0.2188 } },
    { 0.6431, { 0.9556, 0.7801, 0.2284 } }, { 0.6784, { 0.9878, 0.7033, 0.2136 } }, { 0.7216, { 0.9959, 0.587, 0.169 } },
    { 0.7686, { 0.9723, 0.4456, 0.108 } }, { 0.8196, { 0.9157, 0.3053, 0.0513 } }, { 0.8706, { 0.8317, 0.1991, 0.0213 } },
    { 0.9216, { 0.7169, 0.1127, 0.0063 } }, { 0.9725, { 0.571, 0.0447, 0.0053 } }, { 1, { 0.4796, 0.0158, 0.0106 } },
};
static const struct pel_colormap_point coolwarm[] = {
    { 0, { 0.23, 0.299, 0.754 } }, { 0.082, { 0.3284, 0.4396, 0.87 } }, { 0.1562, { 0.4247, 0.5583, 0.9457 } },
    { 0.2266, { 0.5208, 0.6589, 0.9881 } }, { 0.2969, { 0.6181, 0.7435, 0.9998 } }, { 0.3672, { 0.7123, 0.8082, 0.9805 } },
    { 0.4414, { 0.8033, 0.8514, 0.9281 } }, { 0.5039, { 0.8698, 0.8636, 0.8599 } }, { 0.5742, { 0.9326, 0.8181, 0.7568 } },
    { 0.6445, { 0.965, 0.7481, 0.6474 } }, { 0.7148, { 0.9678, 0.6563, 0.5365 } }, { 0.7891, { 0.9395, 0.5387, 0.4226 } },
    { 0.8672, { 0.8774, 0.3942, 0.3108 } }, { 0.9375, { 0.796, 0.2415, 0.2204 } }, { 0.9727, { 0.7472, 0.1453, 0.1796 } },
    { 0.9883, { 0.724, 0.0869, 0.1624 } }, { 0.9961, { 0.712, 0.0443, 0.1541 } }, { 1, { 0.706, 0.0161, 0.15 } },
};
static const struct pel_colormap_point bone[] = {
    { 0, { 0, 0, 0 } }, { 0.3651, { 0.3194, 0.3194, 0.4444 } }, { 0.746, { 0.6528, 0.7778, 0.7778 } },
    { 1, { 1, 1, 1 } },
};
static const struct pel_colormap_point hot[] = {
    { 0, { 0.0416, 0, 0 } }, { 0.3651, { 1, 0, 0 } }, { 0.746, { 1, 1, 0 } },
    { 1, { 1, 1, 1 } },
};
static const struct pel_colormap_point copper[] = {
    { 0, { 0, 0, 0 } }, { 0.8095, { 1, 0.6324, 0.4027 } }, { 1, { 1, 0.7812, 0.4975 } },
};
static const struct pel_colormap_point jet[] = {
    { 0, { 0, 0, 0.5 } }, { 0.11, { 0, 0, 1 } }, { 0.125, { 0, 0, 1 } },
    { 0.34, { 0, 0.86, 1 } }, { 0.35, { 0, 0.9, 0.9677 } }, { 0.375, { 0.0806, 1, 0.8871 } },
    { 0.64, { 0.9355, 1, 0.0323 } }, { 0.65, { 0.9677, 0.963, 0 } }, { 0.66, { 1, 0.9259, 0 } },
    { 0.89, { 1, 0.0741, 0 } }, { 0.91, { 0.9091, 0, 0 } }, { 1, { 0.5, 0, 0 } },
};
static const struct pel_colormap_point gray[] = { { 0, { 0, 0, 0 } }, { 1, { 1, 1, 1 } } };
static const struct pel_colormap_point blue_white_red[] = {
    { 0, { 0, 0, 0.5 } }, { 0.25, { 0, 0.25, 1 } }, { 0.5, { 1, 1, 1 } }, { 0.75, { 1, 0.25, 0 } }, { 1, { 0.5, 0, 0 } },
};
static const struct pel_colormap_point rainbow_desaturated[] = {
    { 0, { 0.2784, 0.2784, 0.8588 } }, { 0.143, { 0, 0, 0.3608 } }, { 0.285, { 0, 1, 1 } }, { 0.429, { 0, 0.502, 0 } },
    { 0.571, { 1, 1, 0 } }, { 0.714, { 1, 0.3804, 0 } }, { 0.857, { 0.4196, 0, 0 } }, { 1, { 0.8784, 0.302, 0.302 } },
};
/* Dark blood, flesh, skin, fat, then bone: the colours that an eye expects of a CT of a body. */
static const struct pel_colormap_point ct[] = {
    { 0, { 0.32, 0.1, 0.07 } }, { 0.15, { 0.62, 0.27, 0.18 } }, { 0.35, { 0.84, 0.52, 0.38 } },
    { 0.5, { 0.92, 0.71, 0.52 } }, { 0.65, { 0.95, 0.85, 0.7 } }, { 0.8, { 0.98, 0.94, 0.85 } }, { 1, { 1, 1, 1 } },
};
/* clang-format on */

#define MAP(name, points)                                                                                                                  \
    {                                                                                                                                      \
        name, sizeof points / sizeof *points, points                                                                                       \
    }

static const struct pel_colormap maps[] = {
    MAP("viridis", viridis),
    MAP("plasma", plasma),
    MAP("inferno", inferno),
    MAP("magma", magma),
    MAP("cividis", cividis),
    MAP("turbo", turbo),
    MAP("gray", gray),
    MAP("coolwarm", coolwarm),
    MAP("blue-white-red", blue_white_red),
    MAP("bone", bone),
    MAP("hot", hot),
    MAP("copper", copper),
    MAP("ct", ct),
    MAP("rainbow-desaturated", rainbow_desaturated),
    MAP("jet", jet),
};
enum { MAP_COUNT = sizeof maps / sizeof *maps };

const struct pel_colormap *pel_colormap_find(const char *name)
{
    for (size_t i = 0; name && i < MAP_COUNT; i++)
        if (strcasecmp(name, maps[i].name) == 0)
            return &maps[i];
    return NULL;
}

const char *pel_colormap_name(size_t index)
{
    return index < MAP_COUNT ? maps[index].name : NULL;
}

bool pel_colormap_lookup(const char *name, double t, double rgb[3])
{
    const struct pel_colormap *map = pel_colormap_find(name);
    if (!map)
        return false;
    size_t i = 1;
    t = t > 0 ? t < 1 ? t : 1 : 0; /* NaN becomes 0 */
    while (i + 1 < map->count && map->points[i].t < t)
        i++;
    const struct pel_colormap_point *a = &map->points[i - 1], *b = &map->points[i];
    double f = (t - a->t) / (b->t - a->t);
    for (int c = 0; c < 3; c++)
        rgb[c] = a->rgb[c] * (1 - f) + b->rgb[c] * f;
    return true;
}

/* Levenshtein's distance, upper and lower case alike, of names up to 63 characters. */
static int distance(const char *a, const char *b)
{
    int row[64];
    int n = (int)strnlen(b, 63);
    for (int j = 0; j <= n; j++)
        row[j] = j;
    for (int i = 0; a[i] && i < 63; i++) {
        int corner = row[0];
        row[0] = i + 1;
        for (int j = 1; j <= n; j++) {
            int cost = corner + (tolower((unsigned char)a[i]) != tolower((unsigned char)b[j - 1]));
            corner = row[j];
            int least = row[j] < row[j - 1] ? row[j] + 1 : row[j - 1] + 1;
            row[j] = cost < least ? cost : least;
        }
    }
    return row[n];
}

bool pel_colormap_fail_unknown(const char *name, struct pel_error *error)
{
    enum { SHOWN = 3 };
    const char *nearest[SHOWN] = { NULL };
    int distances[SHOWN];
    for (size_t i = 0; i < MAP_COUNT; i++) {
        int d = distance(name, maps[i].name);
        for (int k = 0; k < SHOWN; k++) {
            if (nearest[k] && distances[k] <= d)
                continue;
            for (int m = SHOWN - 1; m > k; m--) {
                nearest[m] = nearest[m - 1];
                distances[m] = distances[m - 1];
            }
            nearest[k] = maps[i].name;
            distances[k] = d;
            break;
        }
    }
    return pel_fail(error, PEL_ERROR_ARGUMENT, "unknown color map '%.63s'; the nearest of the %d known are %s, %s and %s", name,
                    (int)MAP_COUNT, nearest[0], nearest[1], nearest[2]);
}
