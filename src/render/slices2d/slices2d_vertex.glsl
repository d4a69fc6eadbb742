// SPDX-License-Identifier: MIT
// A polygon for each n slices (section 6), one instance each, from front to back. "Only every n-th slice polygon is drawn"; since the others' texels
// are displaced on it, "we increase width and height of a slice polygon": by as much as the view displaces what the polygon's slabs hold, found by
// projecting the slabs' corners on to its plane. Clip planes, which the paper had trouble with, need nothing here: each slice of a ray is cut for itself.
#include "job.glsl"
#include "space.glsl"
#include "slices2d_space.glsl"
layout(location = 0) in uvec2 seen; // u and v between which anything in these slices can be seen: from | to << 16; 0: nothing
layout(location = 0) uniform int first_polygon;
layout(location = 0) flat out int first_slice;

void main()
{
    int corner = gl_VertexID;
    vec2 side = vec2(corner & 1, corner >> 1);
    first_slice = slices.polygons.y + (first_polygon + gl_InstanceID) * slices.polygons.x;
    // Slabs of the polygon's slices, and its plane in their midst.
    float front = max(float(first_slice) - slices.rules.z, -1.0);
    float back = min(float(first_slice + slices.polygons.x - 1) + slices.rules.w, slices.stack.w);
    float plane = 0.5 * (front + back), eye = slices.stack.z;
    vec2 from = vec2(seen & 0xffffu), to = vec2(seen >> 16), low = vec2(1e30), high = vec2(-1e30);
    bool perspective = slices.rules.y != 0.0, around = perspective && front - eye < 0.05; // the eye is in the slabs
    for (int i = 0; i < 8; i++) {
        vec2 at = mix(from, to, vec2(i & 1, (i >> 1) & 1));
        float m = (i & 4) != 0 ? back : front;
        at = perspective ? slices.eye.xy + (at - slices.eye.xy) * ((plane - eye) / (m - eye)) : at + (plane - m) * slices.eye.xy;
        low = min(low, at);
        high = max(high, at);
    }
    vec4 place = vec4(mix(low - slices.rules.x, high + slices.rules.x, side), slices.stack.x + plane * slices.stack.y, 1.0);
    vec3 pixel = vec3(dot(slices.to_picture[0], place), dot(slices.to_picture[1], place), dot(slices.to_picture[2], place));
    gl_Position = vec4(2.0 * (pixel.xy + 0.5 * pixel.z) / vec2(job.picture.xy) - pixel.z, 0.0, pixel.z);
    if (around)
        gl_Position = vec4(2.0 * side - 1.0, 0.0, 1.0);
    if (from == to || (perspective && back <= eye))
        gl_Position = vec4(0.0, 0.0, 0.0, 1.0);
}
