// SPDX-License-Identifier: MIT
// What a frame is given: the mirror of struct job in gpu_job.c (std140, vec4s only). "Raw" values are the CPU engine's (src/cpu/kernel.h): affine in the data's.
layout(std140, binding = 0) uniform JobBlock {
    // Rays in index space: the ray of pixel (x, y) is P + s D, P = p0 + x px + y py, D likewise; the world distance along it is (s + s_base) |Dw|.
    vec4 p0, px, py, d0, dx, dy, w0, wx, wy;
    vec4 ray;         // s_base, s_least, step, how small a component of D counts as 0
    vec4 box_lo, box_hi;
    ivec4 picture;    // width, height, planes, jitter: 0 for none, else 1 + the frame's number
    vec4 planes[12];  // a x + b y + c z + d >= 0 is kept
    ivec4 dims;       // voxels
    ivec4 cells;      // cells of 4^3 voxel steps; w: skip
    vec4 raw;         // raw = texel * x + y; z: void value, w: how near to it a voxel is void (negative: none is by value)
    vec4 table;       // entry = raw * x + y (half an entry is in it); z: last entry, w: step over unit distance
    vec4 light;       // ambient, power of the highlight, specular coefficient, steps a voxel
    vec4 all_diffuse, all_specular; // coefficient times the lights' colours, summed
    vec4 gradient;    // x: 1 / the volume's range, raw; y: 1 where some voxel is void; z: termination, w: invert
    vec4 to_world[3], normal[3], metric[2];
    ivec4 counts;     // lights, isosurfaces, 1: the picture is encoded at the end, slice planes
    vec4 light_direction[4]; // w: 1 for a headlight
    vec4 light_diffuse[4], light_specular[4];
    vec4 range;       // least, greatest raw value
    vec4 slice_planes[8];
    vec4 iso[16];       // value, opacity
    vec4 iso_color[16];
    // A part of the volume that is drawn by itself (BRICKS); the cells above are its own.
    ivec4 brick, brick_size; // first voxel and voxels of its texture
    ivec4 first_cell;
    vec4 own_lo, own_hi;     // it takes the samples from own_lo up to, not including, own_hi (index positions)
} job;

#ifdef ONE_ISOVALUE // a constant: no loop over them, no look-up of which
#define ISOVALUES 1
#else
#define ISOVALUES job.counts.y
#endif
