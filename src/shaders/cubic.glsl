// SPDX-License-Identifier: MIT
// Exact surfaces (the "correct root finding" of Liu, Clapworthy and Dong 2010, section 4.3.2; Marmitt et al. 2004): along a ray the reconstructed value of a cell is a cubic, whose roots are found between its extrema, where it
// rises or falls alone. No surface is missed, however short the way behind it, and no value is taken between voxels.
#include "root.glsl"
#include "surface.glsl"

ivec3 cell;       // of voxels, into which the ray comes next
ivec3 heading;    // 1 or -1 along each axis, as the ray goes
bvec3 across;     // the axis along which it comes into the cell
bool faced;       // whether the voxels of the face by which it comes are known, from the cell before
vec3 corner;      // of the cell that was taken last
vec4 low, high;   // its voxels in the order of the ray: (x, y) = 00 10 01 11 at the z where it comes in, and at that where it leaves; 1 is onwards
vec2 range;       // least and greatest of them
bool carried;     // whether the value where the ray came in is known from the cell before,
float carry;      // and that value, or one on the same side of all isovalues
vec4 cubic;       // c0 + c1 u + c2 u^2 + c3 u^3, u from 0 to 1 on the way through the cell

// Takes the voxels of one face, that which lies onwards; those of the face that it was before become those of the face behind. Two cells have a face in common: four voxels are fetched, not eight.
void take_face()
{
    ivec3 steps = heading * min(job.dims.xyz - 1, ivec3(1)), behind = cell + max(-steps, ivec3(0));
    ivec3 first = behind + mix(ivec3(0), steps, bvec3(faced && across.x, faced && across.y, faced && across.z));
    ivec3 u = across.x ? ivec3(0, steps.y, 0) : ivec3(steps.x, 0, 0), v = across.z ? ivec3(0, steps.y, 0) : ivec3(0, 0, steps.z);
    vec4 face = vec4(voxel_within(first), voxel_within(first + u), voxel_within(first + v), voxel_within(first + u + v));
    if (across.x) {
        low = vec4(low.y, face.x, low.w, face.y);
        high = vec4(high.y, face.z, high.w, face.w);
    } else if (across.y) {
        low = vec4(low.zw, face.xy);
        high = vec4(high.zw, face.zw);
    } else {
        low = high;
        high = face;
    }
}

// Whether a surface may be in the cell whose voxels are taken.
bool may_hold()
{
#ifdef VOIDS
    if (any(isnan(low)) || any(isnan(high))) {
        carried = false;
        return false;
    }
#endif
    vec4 least = min(low, high), most = max(low, high);
    range = vec2(min(min(least.x, least.y), min(least.z, least.w)), max(max(most.x, most.y), max(most.z, most.w)));
    bool found = false;
    for (int i = 0; i < ISOVALUES; i++) {
        bool under = range.x < job.iso[i].x;
        found = found || under != (range.y < job.iso[i].x) || (carried && (carry < job.iso[i].x) != under);
    }
    if (!found)
        carry = range.x;
    carried = carried || !found;
    return found;
}

// The value at a place in the cell, never beyond its voxels': neighbours agree on which side the face between them lies.
float value_at(vec3 f)
{
    f = clamp(f, vec3(0.0), vec3(1.0));
    vec4 v = low + f.z * (high - low);
    vec2 row = v.xy + f.y * (v.zw - v.xy);
    return clamp(row.x + f.x * (row.y - row.x), range.x, range.y);
}

float cubic_at(float u)
{
    return clamp(cubic.x + u * (cubic.y + u * (cubic.z + u * cubic.w)), range.x, range.y);
}

// The trilinear interpolant along f + u d.
vec4 cubic_along(vec3 f, vec3 d)
{
    vec4 rise = high - low;
    float x = low.y - low.x, y = low.z - low.x, z = rise.x, xy = low.w - low.z - x, xz = rise.y - rise.x, yz = rise.z - rise.x, xyz = rise.w - rise.z - xz;
    vec4 c;
    c.x = low.x + x * f.x + y * f.y + z * f.z + xy * f.x * f.y + xz * f.x * f.z + yz * f.y * f.z + xyz * f.x * f.y * f.z;
    c.y = x * d.x + y * d.y + z * d.z + xy * (f.x * d.y + f.y * d.x) + xz * (f.x * d.z + f.z * d.x) + yz * (f.y * d.z + f.z * d.y) +
          xyz * (f.x * f.y * d.z + f.x * f.z * d.y + f.y * f.z * d.x);
    c.z = xy * d.x * d.y + xz * d.x * d.z + yz * d.y * d.z + xyz * (f.x * d.y * d.z + f.y * d.x * d.z + f.z * d.x * d.y);
    c.w = xyz * d.x * d.y * d.z;
    return c;
}

// Where the cubic's slope is 0 between 0 and 1, in order; 1 where it is not.
vec2 extrema()
{
    float a = 3.0 * cubic.w, b = cubic.z, discriminant = b * b - a * cubic.y;
    if (discriminant <= 0.0)
        return vec2(1.0);
    float q = -(b + (b < 0.0 ? -1.0 : 1.0) * sqrt(discriminant));
    vec2 u = vec2(abs(a) > 1e-30 ? q / a : 1.0, abs(q) > 1e-30 ? cubic.y / q : 1.0);
    u = mix(vec2(1.0), u, bvec2(u.x > 0.0 && u.x < 1.0, u.y > 0.0 && u.y < 1.0)); // NaN: none
    return vec2(min(u.x, u.y), max(u.x, u.y));
}

// Root between a and b, where the cubic is f and g, on different sides of the isovalue.
float cubic_root(float iso, float a, float f, float b, float g)
{
    Bracket k = Bracket(a, b, f - iso, g - iso);
    for (int i = 0; i < 6; i++) {
        float root = bracket_guess(k);
        bracket_narrow(k, root, cubic_at(root) - iso);
    }
    return bracket_guess(k);
}

// One of five.
float one_of(int i, float first, vec4 rest)
{
    return i == 0 ? first : i == 1 ? rest.x : i == 2 ? rest.y : i == 3 ? rest.z : rest.w;
}

// The cell between two places along the ray, in four pieces that each meet each isovalue once at most: between the value carried over, that at the cell's face, the extrema and the value where
// the ray leaves, the signal only rises or falls.
vec4 piece_u, piece_values; // where they end, and the values there
float piece_first;          // the value where the first begins
int next_piece;             // times the isovalues

void enter_cell(const Ray r, float from, float to)
{
    vec3 f = r.o + from * r.d - corner, d = abs((to - from) * r.d);
    f = mix(1.0 - f, f, greaterThan(heading, ivec3(0))); // in the order of the voxels
    cubic = cubic_along(f, d);
    vec2 turns = extrema();
    float start = value_at(f), end = value_at(f + d);
    piece_first = carried ? carry : start;
    piece_u = vec4(0.0, turns, 1.0);
    piece_values = vec4(start, turns.x < 1.0 ? cubic_at(turns.x) : end, turns.y < 1.0 ? cubic_at(turns.y) : end, end);
    next_piece = 0;
    carry = end;
    carried = true;
}

// The next surface in the cell that was entered, and where on the way through it (0 to 1); false: there is none.
bool next_root(out int i, out float u)
{
    bool found = false;
    float a, b, v, w;
    for (; next_piece < 4 * ISOVALUES && !found; next_piece++) {
        int piece = next_piece / ISOVALUES, j = next_piece - piece * ISOVALUES;
        v = one_of(piece, piece_first, piece_values);
        w = one_of(piece + 1, piece_first, piece_values);
        i = w > v ? j : ISOVALUES - 1 - j;
        found = (v < job.iso[i].x) != (w < job.iso[i].x);
        a = one_of(piece, 0.0, piece_u);
        b = one_of(piece + 1, 0.0, piece_u);
    }
    if (found)
        u = b > a ? cubic_root(job.iso[i].x, a, v, b, w) : a;
    return found;
}
