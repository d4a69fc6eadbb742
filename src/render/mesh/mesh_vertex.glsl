// SPDX-License-Identifier: MIT
// A vertex of a surface: its place and the gradient there, both in index space.
#include "job.glsl"
#include "mesh_space.glsl"
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 gradient;
out vec3 place, slope;

void main()
{
    place = position;
    slope = gradient;
    gl_Position = vec4(on_plane(mesh.clip_x, position), on_plane(mesh.clip_y, position), on_plane(mesh.clip_z, position), on_plane(mesh.clip_w, position));
}
