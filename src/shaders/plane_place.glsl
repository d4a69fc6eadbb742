// SPDX-License-Identifier: MIT
// Where a ray meets a plane of mode slice, in steps from its entry; negative where it does not inside its stretch.
float plane_place(const Ray r, int plane)
{
    float from = dot(job.slice_planes[plane].xyz, r.o) + job.slice_planes[plane].w, along = dot(job.slice_planes[plane].xyz, r.d);
    float at = -from / along, length = float(r.n - 1) + r.fraction;
    if (abs(along) <= 1e-9 * job.ray.z || !(at >= -1e-4 && at <= length + 1e-4)) // world lengths a step
        return -1.0;
    return clamp(at, 0.0, length);
}
