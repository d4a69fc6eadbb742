/* SPDX-License-Identifier: MIT */
/* The whole public interface. Each header also stands alone. */
#ifndef PELLUCID_PELLUCID_H
#define PELLUCID_PELLUCID_H

#include <pellucid/camera.h>
#include <pellucid/dataset.h>
#include <pellucid/device.h>
#include <pellucid/error.h>
#include <pellucid/image.h>
#include <pellucid/io.h>
#include <pellucid/mesh.h>
#include <pellucid/option.h>
#include <pellucid/pick.h>
#include <pellucid/renderer.h>
#include <pellucid/scene.h>
#include <pellucid/statistics.h>
#include <pellucid/transfer.h>
#include <pellucid/version.h>
#include <pellucid/volume.h>

#endif
