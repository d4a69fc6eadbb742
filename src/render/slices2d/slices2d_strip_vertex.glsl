// SPDX-License-Identifier: MIT
// Section 9: the cross-section of a plane with the box, "cut into a set of polygon strips at the intersection line with the object-aligned texture
// slices". Each corner comes with its place, and the slice of voxels before its strip and its plane in one number (slices2d_strips.c).
#include "job.glsl"
#include "space.glsl"
#include "slices2d_space.glsl"
layout(location = 0) in vec4 corner; // stack space; 8 times the slice of voxels before the strip + the plane
layout(location = 0) flat out ivec2 strip; // the slice, the plane

void main()
{
    vec4 place = vec4(corner.xyz, 1.0);
    vec3 pixel = vec3(dot(slices.to_picture[0], place), dot(slices.to_picture[1], place), dot(slices.to_picture[2], place));
    strip = ivec2(int(corner.w) >> 3, int(corner.w) & 7);
    gl_Position = vec4(2.0 * (pixel.xy + 0.5 * pixel.z) / vec2(job.picture.xy) - pixel.z, 0.0, pixel.z);
}
