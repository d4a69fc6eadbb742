/* SPDX-License-Identifier: MIT */
/* One DVR scene through VolPack (Lacroute's shear-warp, 1994), single thread; prints one JSON line.
 *
 *   cc -O2 -o volpack_dvr volpack_dvr.c -lvolpack -lm        (Debian: libvolpack1-dev)
 *   python3 scene_flat.py SCENE | ./volpack_dvr [shade] [picture.ppm]
 *
 * As close to the VTK peers as VolPack allows. What differs, always:
 *  - parallel projection, sized so that the focal plane has the perspective camera's scale;
 *  - one ray a voxel column (the sheared intermediate image), then a 2D bilinear warp to the image size: the work does
 *    not grow with the image, and nothing finer than a voxel is resolved;
 *  - pre-classification: opacity and colour are looked up at the voxels, then interpolated bilinearly inside a slice;
 *    no interpolation between slices, so the step is one slice along the principal axis;
 *  - 8-bit opacity a voxel; opacity corrected for the angle only, not for anisotropic spacing ;
 *  - shading by a table of 7924 quantised normals, headlight direction fixed for the image.
 * edit_ms: a changed opacity curve drawn from the raw voxels through the min-max octree, VolPack's own way for that; reclassify_ms:
 * the same with the volume classified again, after which frames are as fast as frame_ms. */
#include "scene_flat.h"
#include <volpack.h>

struct voxel {
    short normal;
    unsigned char density, gradient;
};

static void ok(vpContext *vpc, vpResult r, const char *what)
{
    if (r == VP_OK)
        return;
    fprintf(stderr, "volpack: %s: %s\n", what, vpGetErrorString(vpGetError(vpc)));
    exit(1);
}

static void opacity_table(const struct scene *s, double shift, float t[256])
{
    double p[64][2];
    memcpy(p, s->op, sizeof p);
    for (int i = 1; i + 1 < s->nop; i++)
        p[i][0] += shift;
    for (int v = 0; v < 256; v++) {
        double o;
        curve(&p[0][0], s->nop, 2, v, &o);
        t[v] = o;
    }
}

static void view(vpContext *vpc, const struct scene *s, int k)
{
    double pos[3], r[3], u[3], b[3], dist = 0;
    scene_camera(s, k, pos, r, u, b);
    for (int i = 0; i < 3; i++)
        dist += (pos[i] - s->focal[i]) * (pos[i] - s->focal[i]);
    double h = sqrt(dist) * tan(s->angle * M_PI / 360), w = h * s->size[0] / s->size[1];
    double depth[3] = { -b[0], -b[1], -b[2] }, *rows[3] = { r, u, depth }; /* VolPack composites from least eye z to greatest */
    int most = s->dims[0] > s->dims[1] ? s->dims[0] : s->dims[1];
    most = most > s->dims[2] ? most : s->dims[2];
    vpMatrix4 model = { { 0 } }, eye = { { 0 } };
    for (int i = 0; i < 3; i++) { /* the volume, centred, its longest side 1, -> world */
        model[i][i] = most * s->spacing[i];
        model[i][3] = (s->dims[i] - 1) * 0.5 * s->spacing[i];
        for (int c = 0; c < 3; c++) {
            eye[i][c] = rows[i][c];
            eye[i][3] -= rows[i][c] * s->focal[c];
        }
    }
    model[3][3] = eye[3][3] = 1;
    vpCurrentMatrix(vpc, VP_MODEL);
    vpIdentityMatrix(vpc);
    vpSetLight(vpc, VP_LIGHT0, VP_DIRECTION, b[0], b[1], b[2]);
    ok(vpc, vpSetMatrix(vpc, model), "model");
    vpCurrentMatrix(vpc, VP_VIEW);
    ok(vpc, vpSetMatrix(vpc, eye), "view");
    vpCurrentMatrix(vpc, VP_PROJECT);
    vpIdentityMatrix(vpc);
    ok(vpc, vpWindow(vpc, VP_PARALLEL, -w, w, -h, h, -4000, 4000), "window");
}

int main(int argc, char **argv)
{
    struct scene s;
    int shade = argc > 1 && !strcmp(argv[1], "shade");
    const char *picture = argc > 1 + shade ? argv[1 + shade] : 0;
    if (!scene_read(stdin, &s)) {
        fprintf(stderr, "no scene on stdin\n");
        return 1;
    }
    unsigned char *d = scene_load(&s);
    size_t n = (size_t)s.dims[0] * s.dims[1] * s.dims[2];
    struct voxel *vox = malloc(n * sizeof *vox), *z = 0;

    vpContext *vpc = vpCreateContext();
    vpSetVolumeSize(vpc, s.dims[0], s.dims[1], s.dims[2]);
    vpSetVoxelSize(vpc, sizeof *vox, 3, 2, 1); /* shading needs normal and density, classification density alone */
    vpSetVoxelField(vpc, 0, sizeof z->normal, vpFieldOffset(z, normal), VP_NORM_MAX);
    vpSetVoxelField(vpc, 1, sizeof z->density, vpFieldOffset(z, density), 255);
    vpSetVoxelField(vpc, 2, sizeof z->gradient, vpFieldOffset(z, gradient), VP_GRAD_MAX);
    ok(vpc, vpSetRawVoxels(vpc, vox, n * sizeof *vox, sizeof *vox, s.dims[0] * sizeof *vox, s.dims[0] * s.dims[1] * (int)sizeof *vox),
       "voxels");
    double t0 = now_ms();
    ok(vpc, vpVolumeNormals(vpc, d, n, 1, 2, 0), "normals");
    double normals_ms = now_ms() - t0;

    static float table[256], weights[256][VP_MAX_MATERIAL];
    static float shades[(VP_NORM_MAX + 1) * VP_MAX_MATERIAL * 3];
    opacity_table(&s, 0, table);
    ok(vpc, vpSetClassifierTable(vpc, 0, 1, table, sizeof table), "classifier");
    vpSetd(vpc, VP_MIN_VOXEL_OPACITY, 0.5 / 255);
    vpSetd(vpc, VP_MAX_RAY_OPACITY, 0.98);

    /* One material a colour point; a density's weights are its place between two points: exactly the linear curve. */
    int nm = s.ncol;
    if (nm > VP_MAX_MATERIAL) {
        fprintf(stderr, "too many colour points for VolPack\n");
        return 1;
    }
    float *wt = &weights[0][0];
    for (int v = 0; v < 256; v++)
        for (int m = 0; m < nm; m++) {
            double hat[64][2], w;
            for (int i = 0; i < nm; i++) {
                hat[i][0] = s.col[i][0];
                hat[i][1] = i == m;
            }
            curve(&hat[0][0], nm, 2, v, &w);
            wt[v * nm + m] = w;
        }
    ok(vpc, vpSetLookupShader(vpc, 3, nm, 0, shades, (VP_NORM_MAX + 1) * nm * 3 * sizeof(float), 1, wt, 256 * nm * sizeof(float)),
       "shader");
    for (int m = 0; m < nm; m++) {
        double *c = s.col[m] + 1, a = shade ? s.light[0] : 1, df = shade ? s.light[1] : 0, sp = shade ? s.light[2] : 0;
        int mat = VP_MATERIAL0 + m;
        vpSetMaterial(vpc, mat, VP_AMBIENT, VP_BOTH_SIDES, a * c[0], a * c[1], a * c[2]);
        vpSetMaterial(vpc, mat, VP_DIFFUSE, VP_BOTH_SIDES, df * c[0], df * c[1], df * c[2]);
        vpSetMaterial(vpc, mat, VP_SPECULAR, VP_BOTH_SIDES, sp, sp, sp);
        vpSetMaterial(vpc, mat, VP_SHINYNESS, VP_BOTH_SIDES, s.light[3], 0, 0);
    }
    vpSetLight(vpc, VP_LIGHT0, VP_COLOR, 1, 1, 1);
    vpEnable(vpc, VP_LIGHT0, 1);
    vpEnable(vpc, VP_LIGHT_BOTH_SIDES, 1);
    unsigned char *image = calloc(3, (size_t)s.size[0] * s.size[1]);
    ok(vpc, vpSetImage(vpc, image, s.size[0], s.size[1], s.size[0] * 3, VP_RGB), "image");

    t0 = now_ms();
    ok(vpc, vpClassifyVolume(vpc), "classify");
    double classify_ms = now_ms() - t0, first_ms = 0, frames[64], raw[64], edits[64];
    for (int k = 0; k < 1 + s.warmup + s.frames; k++) {
        t0 = now_ms();
        view(vpc, &s, k ? k - 1 - s.warmup : 0);
        ok(vpc, vpShadeTable(vpc), "shade table");
        ok(vpc, vpRenderClassifiedVolume(vpc), "render");
        double ms = now_ms() - t0;
        if (k == 0) {
            first_ms = normals_ms + classify_ms + ms;
            FILE *f = picture ? fopen(picture, "wb") : 0;
            if (f) {
                fprintf(f, "P6\n%d %d\n255\n", s.size[0], s.size[1]);
                for (int y = s.size[1] - 1; y >= 0; y--)
                    fwrite(image + (size_t)y * s.size[0] * 3, 3, s.size[0], f);
                fclose(f);
            }
        } else if (k > s.warmup)
            frames[k - 1 - s.warmup] = ms;
    }

    /* A changing transfer function: the min-max octree, made once; then each edit either reclassifies or renders raw. */
    t0 = now_ms();
    ok(vpc, vpMinMaxOctreeThreshold(vpc, 0, 4), "octree threshold");
    ok(vpc, vpCreateMinMaxOctree(vpc, 0, 4), "octree");
    double octree_ms = now_ms() - t0;
    static const double shift[10] = { 2, -2, 4, -4, 3, -3, 1, -1, 5, -5 };
    view(vpc, &s, 0);
    vpShadeTable(vpc);
    for (int i = 0; i < 1 + s.frames; i++) {
        opacity_table(&s, shift[i % 10], table);
        t0 = now_ms();
        ok(vpc, vpClassifyVolume(vpc), "reclassify");
        ok(vpc, vpRenderClassifiedVolume(vpc), "render");
        if (i)
            edits[i - 1] = now_ms() - t0;
    }
    vpDestroyClassifiedVolume(vpc);
    for (int i = 0; i < 1 + s.frames; i++) {
        opacity_table(&s, shift[i % 10], table);
        t0 = now_ms();
        ok(vpc, vpRenderRawVolume(vpc), "render raw");
        if (i)
            raw[i - 1] = now_ms() - t0;
    }
    printf("{\"program\": \"volpack\", \"first_ms\": %.1f, \"normals_ms\": %.1f, \"classify_ms\": %.1f, \"octree_ms\": %.1f", first_ms,
           normals_ms, classify_ms, octree_ms);
    print_list("frame_ms", frames, s.frames);
    print_list("edit_ms", raw, s.frames);
    print_list("reclassify_ms", edits, s.frames);
    printf(", \"version\": \"1.0b3\", \"peak_mb\": %ld}\n", peak_mb());
    return 0;
}
