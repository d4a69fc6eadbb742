/* SPDX-License-Identifier: MIT */
/* pel_write_volume: the format that the name's ending says. */
#include <stdio.h>
#include <string.h>

#include "c_locale.h"
#include "fail.h"
#include "format.h"

static bool write(const struct pel_format *format, const char *path, const struct pel_volume *volume, const struct pel_write_params *params,
                  struct pel_error *error)
{
    const struct pel_c_locale locale = pel_c_locale_begin();
    bool ok = format->write(path, volume, params, error);
    pel_c_locale_end(&locale);
    return ok || pel_fail_in(error, "%s: ", path);
}

bool pel_write_volume(const char *path, const struct pel_volume *volume, const struct pel_write_params *params, struct pel_error *error)
{
    static const struct pel_write_params defaults = PEL_WRITE_PARAMS_INIT;
    if (!params)
        params = &defaults;
    if (!pel_volume_check(volume, error))
        return pel_fail_in(error, "%s: ", path);
    for (size_t i = 0; pel_formats[i]; i++)
        if (pel_formats[i]->write && pel_path_has_ending(path, pel_formats[i]->info.endings))
            return write(pel_formats[i], path, volume, params, error);
    char endings[128];
    size_t used = 0;
    endings[0] = 0;
    for (size_t i = 0; pel_formats[i] && used < sizeof endings; i++)
        if (pel_formats[i]->write)
            used += (size_t)snprintf(endings + used, sizeof endings - used, " %s", pel_formats[i]->info.endings);
    return pel_fail(error, PEL_ERROR_ARGUMENT, "%s: the name's ending says no format that can be written; use one of%s", path, endings);
}
