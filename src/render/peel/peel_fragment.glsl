// SPDX-License-Identifier: MIT
// Section 4.2: all fragments of a cell give its bit; the logic operation OR combines those of the cells behind one pixel.
flat in vec3 disc; // middle and radius
flat in uint bit;
layout(location = 0) out uint mask;

void main()
{
#ifdef DISC
    vec2 away = gl_FragCoord.xy - 0.5 - disc.xy;
    if (dot(away, away) > disc.z * disc.z)
        discard;
#endif
    mask = bit;
}
