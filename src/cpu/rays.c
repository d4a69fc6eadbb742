/* SPDX-License-Identifier: MIT */
#include "rays.h"

#include <math.h>
#include <string.h>

#include "vec.h"

#define RADIANS (3.14159265358979323846 / 180)

/* to = matrix * v, and to = transposed matrix * v. */
static void times(const double matrix[3][3], const double v[3], double to[3])
{
    for (int i = 0; i < 3; i++)
        to[i] = pel_dot(matrix[i], v);
}

static void times_transposed(const double matrix[3][3], const double v[3], double to[3])
{
    for (int i = 0; i < 3; i++)
        to[i] = matrix[0][i] * v[0] + matrix[1][i] * v[1] + matrix[2][i] * v[2];
}

/* A world plane with the normal's side kept, as index-space coefficients. */
static void plane_to_index(const struct pel_volume *volume, const double to_world[3][3], const double origin[3], const double normal[3],
                           double plane[4])
{
    double unit[3] = { normal[0], normal[1], normal[2] }, from[3];
    pel_normalize(unit);
    times_transposed(to_world, unit, plane);
    pel_sub(volume->origin, origin, from);
    plane[3] = pel_dot(unit, from);
}

static void clipping(struct pel_job *job, const struct pel_scene *scene, const double to_world[3][3])
{
    const struct pel_volume *v = scene->volume;
    for (int a = 0; a < 3; a++) {
        job->box_lo[a] = v->dims[a] > 1 ? 0 : -0.5;
        job->box_hi[a] = v->dims[a] > 1 ? (double)(v->dims[a] - 1) : 0.5;
    }
    job->plane_count = 0;
    for (int i = 0; i < scene->clip_plane_count; i++)
        plane_to_index(v, to_world, scene->clip_planes[i].origin, scene->clip_planes[i].normal, job->planes[job->plane_count++]);
    for (int i = 0; scene->clip_box_enabled && i < 6; i++) {
        double origin[3] = { 0, 0, 0 }, normal[3] = { 0, 0, 0 };
        origin[i / 2] = scene->clip_box[i];
        normal[i / 2] = i % 2 ? -1 : 1;
        plane_to_index(v, to_world, origin, normal, job->planes[job->plane_count++]);
    }
    job->slice_count = scene->render.mode == PEL_MODE_SLICE ? 1 + scene->more_slice_count : 0;
    for (int i = 0; i < job->slice_count; i++) {
        const struct pel_plane *plane = i ? &scene->more_slices[i - 1] : &scene->slice;
        plane_to_index(v, to_world, plane->origin, plane->normal, job->slice_planes[i]);
    }
}

/* Rays start at a plane through the box's centre, so that index coordinates stay small. */
static void rays(struct pel_job *job, const struct pel_scene *scene, const double to_index[3][3])
{
    const struct pel_camera *c = &scene->camera;
    double right[3], up[3], forward[3], bounds[6], to_centre[3];
    pel_camera_basis(c, right, up, forward);
    pel_volume_bounds(scene->volume, bounds);
    for (int i = 0; i < 3; i++)
        to_centre[i] = (bounds[2 * i] + bounds[2 * i + 1]) / 2 - c->position[i];
    double base = pel_dot(to_centre, forward), half = c->parallel ? c->parallel_scale : tan(c->view_angle / 2 * RADIANS);
    double du = 2 * half / job->height, u0 = (1.0 / job->width - 1) * half * job->width / job->height, v0 = (1 - 1.0 / job->height) * half;
    double start[3], at_x[3], at_y[3];
    for (int i = 0; i < 3; i++) {
        start[i] = u0 * right[i] + v0 * up[i];
        at_x[i] = du * right[i];
        at_y[i] = -du * up[i];
    }
    double spread = c->parallel ? 1 : base; /* how far the plane's points move with a unit of the offsets */
    double point[3], px[3], py[3];
    for (int i = 0; i < 3; i++) {
        point[i] = c->position[i] + base * forward[i] + spread * start[i] - scene->volume->origin[i];
        px[i] = spread * at_x[i];
        py[i] = spread * at_y[i];
        job->w0[i] = forward[i] + (c->parallel ? 0 : start[i]);
        job->wx[i] = c->parallel ? 0 : at_x[i];
        job->wy[i] = c->parallel ? 0 : at_y[i];
    }
    times(to_index, point, job->p0);
    times(to_index, px, job->px);
    times(to_index, py, job->py);
    times(to_index, job->w0, job->d0);
    times(to_index, job->wx, job->dx);
    times(to_index, job->wy, job->dy);
    double longest = 0;
    for (int i = 0; i < 3; i++)
        longest = fmax(longest, fabs(job->d0[i]) + job->width * fabs(job->dx[i]) + job->height * fabs(job->dy[i]));
    job->along = 1e-12 * longest;
    job->s_base = base;
    job->s_least = c->parallel ? -1e300 : -base;
}

static void optics(struct pel_job *job, const struct pel_scene *scene, const double to_world[3][3], const double to_index[3][3])
{
    double metric[3][3], voxel = pel_volume_least_spacing(scene->volume); /* lengths in voxels: the same numbers in metres and in microns */
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            job->to_world[i][j] = (float)(to_world[i][j] / voxel);
            job->normal[i][j] = (float)(to_index[j][i] * voxel);
            metric[i][j] = pel_dot(to_index[i], to_index[j]) * voxel * voxel;
        }
    float m[6] = { (float)metric[0][0],       (float)metric[1][1],       (float)metric[2][2],
                   (float)(2 * metric[0][1]), (float)(2 * metric[0][2]), (float)(2 * metric[1][2]) };
    memcpy(job->metric, m, sizeof m);
    double size = metric[0][0] + metric[1][1] + metric[2][2];
    job->orthogonal = fabs(metric[0][1]) + fabs(metric[0][2]) + fabs(metric[1][2]) < 1e-9 * size;
    job->light_count = scene->light_count;
    job->headlight_only = true;
    for (int l = 0; l < scene->light_count; l++) {
        double direction[3];
        memcpy(direction, scene->lights[l].direction, sizeof direction);
        pel_normalize(direction);
        job->lights[l].headlight = scene->lights[l].headlight;
        job->headlight_only &= scene->lights[l].headlight;
        for (int i = 0; i < 3; i++) {
            job->lights[l].direction[i] = (float)direction[i];
            job->lights[l].color[i] = (float)scene->lights[l].color[i];
        }
    }
}

/* What the scene's settings say, but for classification (classify.c). */
static void settings(struct pel_job *job, const struct pel_scene *scene)
{
    const struct pel_render_settings *s = &scene->render;
    job->step = s->step * pel_volume_least_spacing(scene->volume);
    job->steps_a_voxel = (float)(1 / s->step);
    job->classification = s->classification;
    job->nearest = s->mode != PEL_MODE_ISOSURFACE && (s->reconstruction == PEL_RECONSTRUCTION_NEAREST ||
                                                      (s->reconstruction == PEL_RECONSTRUCTION_AUTO && scene->volume->labels));
    job->roots = s->roots;
    job->shade = s->shade;
    job->invert = s->invert;
    job->termination = s->termination < 1 ? (float)s->termination : 2; /* 2 is never reached */
    job->ambient = (float)s->ambient;
    job->diffuse = (float)s->diffuse;
    job->specular = (float)s->specular;
    job->power = (float)s->specular_power;
    for (int c = 0; c < 3; c++) {
        job->all_diffuse[c] = job->all_specular[c] = 0;
        for (int l = 0; l < job->light_count; l++) {
            job->all_diffuse[c] += job->diffuse * job->lights[l].color[c];
            job->all_specular[c] += job->specular * job->lights[l].color[c];
        }
    }
    double longest = 0; /* voxels a step, along any axis */
    for (int a = 0; a < 3; a++)
        longest = fmax(longest, job->step / scene->volume->spacing[a]);
    /* Values at segment ends tell of the segment only where the two ends' cells touch. */
    job->skip = s->skip && !(longest > PEL_CELL_SIZE * 0.5 && ((s->mode == PEL_MODE_ISOSURFACE && s->roots == PEL_ROOTS_STEPS) ||
                                                               s->classification == PEL_CLASSIFICATION_PREINTEGRATED));
}

/* Octants of directions (distance_map.h) into which rays go. A component of the direction is linear over the picture, so its signs are
 * those at the corners; lanes beyond the edge count too, and 0 goes with both. */
unsigned pel_rays_octants(const struct pel_job *job)
{
    unsigned set = 0xff;
    for (int a = 0; a < 3; a++) {
        double least = INFINITY, most = -INFINITY;
        for (int corner = 0; corner < 4; corner++) {
            double d = job->d0[a] + (corner & 1 ? job->width + 3 : 0) * job->dx[a] + (corner & 2 ? job->height + 3 : 0) * job->dy[a];
            least = fmin(least, d);
            most = fmax(most, d);
        }
        static const unsigned upward[3] = { 0x55, 0x33, 0x0f }; /* octants with the axis' bit clear */
        if (least > 1e3 * job->along)
            set &= upward[a];
        if (most < -1e3 * job->along)
            set &= ~upward[a];
    }
    return set;
}

/* Every ray of a perspective camera goes through the eye, p0 - s_base d0: a corner q is met by pixel (x, y) where q - eye is a multiple of
 * d0 + x dx + y dy; in parallel, where q - p0 is x px + y py and a multiple of d0. */
bool pel_rays_rectangle(const struct pel_job *job, bool parallel, const double lo[3], const double hi[3], int rectangle[4])
{
    double columns[3][3], inverse[3][3], from[3], least[2] = { INFINITY, INFINITY }, most[2] = { -INFINITY, -INFINITY };
    int behind = 0;
    for (int i = 0; i < 3; i++) {
        columns[i][0] = parallel ? job->px[i] : job->dx[i];
        columns[i][1] = parallel ? job->py[i] : job->dy[i];
        columns[i][2] = job->d0[i];
        from[i] = job->p0[i] - (parallel ? 0 : job->s_base * job->d0[i]);
    }
    bool unknown = pel_invert3((const double(*)[3])columns, inverse) == 0;
    for (int corner = 0; corner < 8 && !unknown; corner++) {
        double q[3], at[3];
        for (int a = 0; a < 3; a++)
            q[a] = (corner >> a & 1 ? hi[a] : lo[a]) - from[a];
        times((const double(*)[3])inverse, q, at);
        if (!parallel && at[2] <= 0) {
            behind++;
            continue;
        }
        for (int i = 0; i < 2; i++) {
            double pixel = parallel ? at[i] : at[i] / at[2];
            least[i] = fmin(least[i], pixel);
            most[i] = fmax(most[i], pixel);
        }
    }
    const int size[2] = { job->width, job->height };
    for (int i = 0; i < 2; i++) {
        bool whole = unknown || (behind > 0 && behind < 8);
        rectangle[i] = whole ? 0 : (int)fmin(fmax(floor(least[i] - 0.01), 0), size[i]);
        rectangle[2 + i] = whole ? size[i] : (int)fmin(fmax(ceil(most[i] + 0.01) + 1, 0), size[i]);
    }
    return behind < 8 && rectangle[0] < rectangle[2] && rectangle[1] < rectangle[3];
}

void pel_rays_setup(struct pel_job *job, const struct pel_scene *scene, int jitter, int width, int height)
{
    const struct pel_volume *v = scene->volume;
    double affine[3][4], to_world[3][3], to_index[3][3];
    pel_volume_matrix(v, affine);
    for (int i = 0; i < 3; i++)
        memcpy(to_world[i], affine[i], sizeof to_world[i]);
    pel_invert3((const double(*)[3])to_world, to_index);
    job->jitter = jitter;
    job->width = width;
    job->height = height;
    clipping(job, scene, (const double(*)[3])to_world);
    rays(job, scene, (const double(*)[3])to_index);
    optics(job, scene, (const double(*)[3])to_world, (const double(*)[3])to_index);
    settings(job, scene);
}
