// SPDX-License-Identifier: MIT
// Isosurfaces by the marcher: a filling that looks at segments and takes those that a surface crosses (crossings.glsl).
#include "job.glsl"
#include "space.glsl"
#include "sampling.glsl"
#include "shading.glsl"
#include "gather.glsl"
#include "crossings.glsl"

#define TAKES

void march_begin(const Ray r)
{
    gather_begin();
    march_gap();
}

#include "march.glsl"
