/* SPDX-License-Identifier: MIT */
#include <pellucid/transfer.h>

bool pel_transfer_automatic(struct pel_transfer *transfer, const struct pel_volume *volume, enum pel_transfer_purpose purpose,
                            struct pel_error *error)
{
    double lo = volume->range[0], hi = volume->range[1];
    (void)purpose;
    struct pel_opacity_point points[] = { { lo + 0.2 * (hi - lo), 0 }, { hi, 0.3 } };
    transfer->unit_distance = pel_volume_mean_spacing(volume);
    return pel_transfer_set_colormap(transfer, "viridis", lo, hi, error) && pel_transfer_set_opacities(transfer, points, 2, error);
}

double pel_isovalue_automatic(const struct pel_volume *volume)
{
    return volume->range[0] + 0.35 * (volume->range[1] - volume->range[0]);
}
