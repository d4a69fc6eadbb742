// SPDX-License-Identifier: MIT
// What a frame tells the stages beside job.glsl: the mirror of struct pel_peel_block (peel.h).
layout(std140, binding = 1) uniform PeelBlock {
    vec4 to_pixel[3]; // index position, less `from`, to pixel times w, and w: the distance along the view axis; w: added
    vec4 from;        // xyz: the eye (parallel: where w does not matter); w: the least w that counts as before the eye
    ivec4 grid;       // macro-cells along each axis; voxel steps along an edge of one (granularity)
    ivec4 major;      // the major axis; the sign of the optical axis along it; cell-slices along it (TotalSlice); slices of a layer
    ivec4 tile;       // of the screen: first pixel, size
    ivec4 wide;       // x: 1 where every cell must count as active; y: levels of the min-max tree
    ivec4 tree[3];    // where the levels start
} peel;
