/* SPDX-License-Identifier: MIT */
/* The pseudo-random part of a step by which a pixel's samples are moved: a hash, so that it is the same on every run and thread. Frame j of
 * a refined picture moves them on by j times the golden fraction, modulo 1, so that any number of frames spreads evenly over the step. */
#ifndef PEL_CPU_JITTER_H
#define PEL_CPU_JITTER_H

#include <stdint.h>

static inline float pel_jitter(int x, int y, int frame)
{
    uint32_t h = (uint32_t)x * 0x9e3779b1u + (uint32_t)y * 0x85ebca77u + 0x27d4eb2fu;
    h = (h ^ (h >> 15)) * 0x2c1b3c6du;
    h = (h ^ (h >> 12)) * 0x297a2d39u;
    h ^= h >> 15;
    h += (uint32_t)frame * 0x9e3779b9u;
    return (float)(h >> 8) * 0x1p-24f;
}

#endif
