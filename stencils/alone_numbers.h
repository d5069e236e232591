/* Numbers of single or double precision that stand in for those of a scene (alone.h). */
#ifndef PHICHAIN_ALONE_NUMBERS_H
#define PHICHAIN_ALONE_NUMBERS_H

#if ALONE_FLOAT
typedef float phi_real;
#define PHI_HALF 0.5f
#define PHI_HALVES 4097.0f
#define PHI_WHOLE 0x1p+23f
#define PHI_EPSILON 0x1p-23f
#define PHI_NOISE 0x1p-12f
#define PHI_MARGIN 0x1p-8f
#define PHI_SHARE 0.6f
#define PHI_SLACK 0.9375f
#define PHI_LEEWAY 64
#define PHI_HUGE 80
#define PHI_WORD uint32_t
#define PHI_DIGITS 23
#define PHI_DIGITS_MASK UINT32_C(0x007fffff)
#define PHI_ONE_BITS UINT32_C(0x3f800000)
#define PHI_COUNT_BITS UINT32_C(0x4b000000)
#define PHI_COUNT_ONE 0x1.0000fep+23f
#define PHI_ROUNDER 0x1.8p+23f
#define PHI_NEAR 0x1p-120f
#define PHI_FAR 0x1p+120f
#define PHI_TURN_HIGH 0x1.921fb6p+2f
#define PHI_TURN_LOW (-0x1.777a5cp-23f)
#define PHI_SCALES 9.0f, 1.5f, 0.1f
#define phi_abs fabsf
#define phi_fma fmaf
#define phi_cos cosf
#define phi_sin sinf
#else
typedef double phi_real;
#define PHI_HALF 0.5
#define PHI_HALVES 134217729.0
#define PHI_WHOLE 0x1p+52
#define PHI_EPSILON 0x1p-52
#define PHI_NEIGHBOUR 0x1p-27
#define PHI_NOISE 0x1p-26
#define PHI_MARGIN 0x1p-8
#define PHI_SHARE 0.6
#define PHI_SLACK 0.9375
#define PHI_LEEWAY 64
#define PHI_HUGE 700
#define PHI_WORD uint64_t
#define PHI_DIGITS 52
#define PHI_DIGITS_MASK UINT64_C(0x000fffffffffffff)
#define PHI_ONE_BITS UINT64_C(0x3ff0000000000000)
#define PHI_COUNT_BITS UINT64_C(0x4330000000000000)
#define PHI_COUNT_ONE 0x1.00000000003ffp+52
#define PHI_ROUNDER 0x1.8p+52
#define PHI_NEAR 0x1p-1016
#define PHI_FAR 0x1p+1016
#define PHI_TURN_HIGH 0x1.921fb54442d18p+2
#define PHI_TURN_LOW 0x1.1a62633145c07p-52
#define PHI_SCALES 9.0, 1.5, 0.1
#define phi_abs fabs
#define phi_fma fma
#define phi_cos cos
#define phi_sin sin
#endif
#define PHI_ROOM 64
#define PHI_SCALE_COUNT 3
#define PHI_WEIGHT_SCALE 2

#endif
