/* Passes over n states in component-major arrays: heyoka's function takes `width` of them a call, ours all. */
#include <stddef.h>

typedef void peer_function(double *out, const double *in, const double *par, const double *time, size_t stride);
typedef void own_function(size_t n, const double *q, const double *v, double *a);

void batch_peer(peer_function *function, size_t width, size_t n, const double *states, double *out, int passes)
{
    for (int pass = 0; pass < passes; ++pass) {
        for (size_t first = 0; first + width <= n; first += width) {
            function(out + first, states + first, NULL, NULL, n);
        }
    }
}

void batch_own(own_function *function, size_t nq, size_t n, const double *states, double *out, int passes)
{
    for (int pass = 0; pass < passes; ++pass) {
        function(n, states, states + nq * n, out);
    }
}
