/* What an expert writes by hand for paper A's chain of LINKS links: absolute angles, the mass matrix in closed form, an L D L^T
 * solve in place, straight-line up to four links; sines and cosines by the C library, or by a lean kernel for moderate angles (OWN_SINCOS). */
#include <math.h>
#include <stdint.h>
#include <string.h>

#define MASS (1.0f / LINKS)
#define LENGTH (1.0f / LINKS)
#define COM (0.5f / LINKS)
#if LINKS <= 4
#define UNROLLED _Pragma("GCC unroll 8")
#else
#define UNROLLED
#endif

void expert_forward_dynamics(const float q[LINKS], const float v[LINKS], const float u[LINKS], float a[LINKS]);

static inline void turned(float x, float *sine, float *cosine)
{
#ifdef OWN_SINCOS
    const float quarter = (x * 0.63661977f + 12582912.0f) - 12582912.0f;
    const int32_t quadrant = (int32_t)quarter;
    const float r = ((x - quarter * 1.5707855f) - quarter * 1.0804334e-5f) - quarter * 6.0771006e-11f;
    const float z = r * r;
    const float s = r + r * z * (-0.16666655f + z * (0.0083321609f - z * 0.00019515296f));
    const float c = 1.0f + z * (-0.5f + z * (0.041666638f + z * (-0.0013888379f + z * 2.4433157e-5f)));
    const float first = (quadrant & 1) != 0 ? c : s, second = (quadrant & 1) != 0 ? s : c;
    *sine = (quadrant & 2) != 0 ? -first : first;
    *cosine = ((quadrant + 1) & 2) != 0 ? -second : second;
#else
    *sine = sinf(x);
    *cosine = cosf(x);
#endif
}

void expert_forward_dynamics(const float q[LINKS], const float v[LINKS], const float u[LINKS], float a[LINKS])
{
    float sine[LINKS], cosine[LINKS], rate[LINKS], m[LINKS][LINKS], b[LINKS], angle = 0.0f, speed = 0.0f;
    UNROLLED
    for (int i = 0; i < LINKS; ++i) {
        angle += q[i];
        speed += v[i];
        rate[i] = speed * speed;
        turned(angle, &sine[i], &cosine[i]);
    }
    UNROLLED
    for (int i = 0; i < LINKS; ++i) {
        const float mu_i = MASS * COM + LENGTH * MASS * (float)(LINKS - 1 - i);
        b[i] = u[i] - (i + 1 < LINKS ? u[i + 1] : 0.0f) - 9.81f * mu_i * sine[i];
        UNROLLED
        for (int j = 0; j < LINKS; ++j) {
            const float mu = MASS * COM + LENGTH * MASS * (float)(LINKS - 1 - (i > j ? i : j));
            if (j != i) {
                b[i] -= LENGTH * mu * (sine[i] * cosine[j] - cosine[i] * sine[j]) * rate[j];
            }
            if (j <= i) {
                m[i][j] = j == i ? MASS * COM * COM + LENGTH * LENGTH * MASS * (float)(LINKS - 1 - i)
                                 : LENGTH * mu * (cosine[i] * cosine[j] + sine[i] * sine[j]);
            }
        }
    }
    UNROLLED
    for (int k = 0; k < LINKS; ++k) {
        const float inverse = 1.0f / m[k][k];
        UNROLLED
        for (int i = k + 1; i < LINKS; ++i) {
            const float factor = m[i][k] * inverse;
            UNROLLED
            for (int j = k + 1; j <= i; ++j) {
                m[i][j] -= factor * m[j][k];
            }
            b[i] -= factor * b[k];
        }
    }
    UNROLLED
    for (int k = LINKS - 1; k >= 0; --k) {
        UNROLLED
        for (int i = k + 1; i < LINKS; ++i) {
            b[k] -= m[i][k] * b[i];
        }
        b[k] /= m[k][k];
    }
    UNROLLED
    for (int k = LINKS - 1; k > 0; --k) {
        a[k] = b[k] - b[k - 1];
    }
    a[0] = b[0];
}
