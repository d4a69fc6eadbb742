/* SPDX-License-Identifier: MIT */
#include <pellucid/version.h>

#define TEXT_OF(x) #x
#define TEXT(x) TEXT_OF(x)

const char *pel_version(void)
{
    return TEXT(PEL_VERSION_MAJOR) "." TEXT(PEL_VERSION_MINOR) "." TEXT(PEL_VERSION_PATCH);
}
