/* SPDX-License-Identifier: MIT */
/* Which instruction set's kernels to run. The build says which sets it has (PEL_X86_LEVELS; meson.build); the list names the widest first.
 */
#include <string.h>

#include "fail.h"
#include "kernel.h"

#define DECLARE(ID)                                                                                                                        \
    extern const struct pel_kernels pel_kernels_##ID##_u8, pel_kernels_##ID##_u16, pel_kernels_##ID##_f32, pel_kernels_##ID##_wide;
#define KERNELS(ID) { &pel_kernels_##ID##_u8, &pel_kernels_##ID##_u16, &pel_kernels_##ID##_f32, &pel_kernels_##ID##_wide }

#ifdef PEL_X86_LEVELS
DECLARE(v2)
#if PEL_X86_LEVELS > 2
DECLARE(v3)
DECLARE(v4)
#endif

/* What GCC's and Clang's -march=x86-64-vN may use, as far as the kernels do. */
static bool has_v2(void)
{
    return __builtin_cpu_supports("sse4.2") && __builtin_cpu_supports("ssse3") && __builtin_cpu_supports("popcnt");
}

#if PEL_X86_LEVELS > 2
static bool has_v3(void)
{
    return has_v2() && __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi") &&
           __builtin_cpu_supports("bmi2");
}

static bool has_v4(void)
{
    return has_v3() && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512cd") &&
           __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
}
#endif

static const struct isa {
    const char *name;
    bool (*runs_here)(void);
    const struct pel_kernels *kernels[PEL_KERNEL_KINDS];
} isas[] = {
#if PEL_X86_LEVELS > 2
    { "x86-64-v4", has_v4, KERNELS(v4) },
    { "x86-64-v3", has_v3, KERNELS(v3) },
#endif
    { "x86-64-v2", has_v2, KERNELS(v2) },
};
#else
DECLARE(native)

static bool always(void)
{
    return true;
}

static const struct isa {
    const char *name;
    bool (*runs_here)(void);
    const struct pel_kernels *kernels[PEL_KERNEL_KINDS];
} isas[] = {
    { "native", always, KERNELS(native) },
};
#endif

bool pel_kernels_find(const char *wanted, const struct pel_kernels *kernels[PEL_KERNEL_KINDS], const char **name, struct pel_error *error)
{
    if (wanted && !wanted[0])
        wanted = NULL;
    char known[128] = "";
    for (size_t i = 0; i < sizeof isas / sizeof *isas; i++) {
        bool runs = isas[i].runs_here();
        if (runs && (!wanted || !strcmp(wanted, isas[i].name))) {
            memcpy(kernels, isas[i].kernels, sizeof isas[i].kernels);
            *name = isas[i].name;
            return true;
        }
        if (runs && strlen(known) + strlen(isas[i].name) + 2 < sizeof known)
            strcat(strcat(known, " "), isas[i].name);
    }
    if (!wanted)
        return pel_fail(error, PEL_ERROR_UNSUPPORTED,
                        "this processor lacks SSE4.2 (x86-64-v2), which the ray caster needs; use the technique 'reference'");
    return pel_fail(error, PEL_ERROR_ARGUMENT, "PELLUCID_ISA: no instruction set '%s' on this machine; it runs%s", wanted, known);
}
