// SPDX-License-Identifier: MIT
// Whether an isosurface may pass where voxels lie between two raw values. The margin is more than rounding moves a reconstructed value by; where texels carry an offset, they round by it.
bool holds_isovalue(float least, float greatest)
{
    float margin = 4e-6 * (abs(least) + abs(greatest)) + 5e-7 * abs(job.raw.y);
    for (int i = 0; i < ISOVALUES; i++)
        if (least - margin <= job.iso[i].x && job.iso[i].x <= greatest + margin)
            return true;
    return false;
}
