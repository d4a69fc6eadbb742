/* SPDX-License-Identifier: MIT */
/* The options of slices2d, for both engines. */
#ifndef PEL_RENDER_SLICES2D_H
#define PEL_RENDER_SLICES2D_H

#include "shear_factor.h"

enum pel_slices2d_correction { PEL_CORRECTION_EXACT, PEL_CORRECTION_LINEAR };
enum pel_slices2d_coordinates { PEL_COORDINATES_CORRECTED, PEL_COORDINATES_SHARED };
enum pel_slices2d_surface { PEL_SURFACE_CROSSING, PEL_SURFACE_ALPHA_TEST };
enum pel_slices2d_lighting { PEL_LIGHTING_SCENE, PEL_LIGHTING_GLOBAL, PEL_LIGHTING_VOXEL };

struct pel_slices2d_options {
    int supersampling;
    enum pel_slices2d_correction correction;
    int every;        /* a slice for so many slices of voxels */
    double budget_ms; /* 0: none */
    /* The CPU engine's. */
    enum pel_intermediate intermediate;
    double rays;
    /* The GPU engine's. */
    int slices_per_polygon; /* index into 1, 2, 4, 8 */
    enum pel_slices2d_coordinates coordinates;
    double blend; /* degrees */
    enum pel_slices2d_surface surface;
    enum pel_slices2d_lighting lighting;
    double ambient_color[4];
};

#endif
