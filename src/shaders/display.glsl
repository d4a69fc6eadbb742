// SPDX-License-Identifier: MIT
// Linear light back to display values (the sRGB curve): the colour without its opacity is encoded.
vec3 to_display(vec3 c)
{
    return mix(1.055 * pow(max(c, vec3(0.0)), vec3(1.0 / 2.4)) - 0.055, 12.92 * c, lessThanEqual(c, vec3(0.0031308)));
}
