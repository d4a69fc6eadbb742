/* SPDX-License-Identifier: MIT */
/* Extraction for those who have a min-max grid already. */
#ifndef PEL_DATA_MESH_EXTRACT_H
#define PEL_DATA_MESH_EXTRACT_H

#include <pellucid/mesh.h>

#include "minmax.h"

/* pel_mesh_extract with the volume's grid. */
struct pel_mesh *pel_mesh_extract_by(const struct pel_volume *volume, const struct pel_minmax *minmax, const struct pel_mesh_params *params,
                                     struct pel_error *error);

#endif
