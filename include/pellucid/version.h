/* SPDX-License-Identifier: MIT */
/* Version: of the headers at compile time, of the library at run time. */
#ifndef PELLUCID_VERSION_H
#define PELLUCID_VERSION_H

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

#define PEL_VERSION_MAJOR 0
#define PEL_VERSION_MINOR 1
#define PEL_VERSION_PATCH 0

/* "0.1.0" */
const char *pel_version(void);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif
#endif
