/* SPDX-License-Identifier: MIT */
/* Numbers in texts that programs read have a point, whatever the host program's locale says: the "C" locale, for this thread and a while.
 */
#ifndef PEL_BASE_C_LOCALE_H
#define PEL_BASE_C_LOCALE_H

#include <locale.h>

struct pel_c_locale {
    locale_t c, old;
};

/* Where memory is wanting, the locale stays as it is. */
static inline struct pel_c_locale pel_c_locale_begin(void)
{
    struct pel_c_locale l = { newlocale(LC_ALL_MASK, "C", (locale_t)0), (locale_t)0 };
    if (l.c)
        l.old = uselocale(l.c);
    return l;
}

static inline void pel_c_locale_end(const struct pel_c_locale *l)
{
    if (!l->c)
        return;
    uselocale(l->old);
    freelocale(l->c);
}

#endif
