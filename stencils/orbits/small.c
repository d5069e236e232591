/* Linear algebra of a few rows, row-major, in the caller's memory. */

/* A x = b for so many right sides, by elimination with the largest pivot of each column; A and b are used up, b holds x behind.
 * The sign of det A comes back, 0 where A is singular or no numbers. */
static int small_solve(const int n, phi_real *a, const int sides, phi_real *b)
{
    int sign = 1;
    for (int k = 0; k < n; ++k) {
        int pivot = k;
        for (int i = k + 1; i < n; ++i) {
            if (fabs(a[i * n + k]) > fabs(a[pivot * n + k])) {
                pivot = i;
            }
        }
        if (!(fabs(a[pivot * n + k]) > 0)) {
            return 0;
        }
        if (pivot != k) {
            for (int j = k; j < n; ++j) {
                const phi_real kept = a[k * n + j];
                a[k * n + j] = a[pivot * n + j];
                a[pivot * n + j] = kept;
            }
            for (int j = 0; j < sides; ++j) {
                const phi_real kept = b[k * sides + j];
                b[k * sides + j] = b[pivot * sides + j];
                b[pivot * sides + j] = kept;
            }
            sign = -sign;
        }
        sign = a[k * n + k] < 0 ? -sign : sign;
        for (int i = k + 1; i < n; ++i) {
            const phi_real factor = a[i * n + k] / a[k * n + k];
            for (int j = k + 1; j < n; ++j) {
                a[i * n + j] -= factor * a[k * n + j];
            }
            for (int j = 0; j < sides; ++j) {
                b[i * sides + j] -= factor * b[k * sides + j];
            }
        }
    }
    for (int k = n - 1; k >= 0; --k) {
        for (int j = 0; j < sides; ++j) {
            phi_real sum = b[k * sides + j];
            for (int i = k + 1; i < n; ++i) {
                sum -= a[k * n + i] * b[i * sides + j];
            }
            b[k * sides + j] = sum / a[k * n + k];
        }
    }
    return sign;
}

/* L with A = L L^T in place of A, zeros above; 0 where A is not positive definite. */
static int small_root(const int n, phi_real *a)
{
    for (int j = 0; j < n; ++j) {
        for (int i = 0; i < n; ++i) {
            phi_real sum = a[i * n + j];
            for (int k = 0; k < j && i >= j; ++k) {
                sum -= a[i * n + k] * a[j * n + k];
            }
            if (i < j) {
                a[i * n + j] = 0;
            } else if (i > j) {
                a[i * n + j] = sum / a[j * n + j];
            } else if (sum > 0) {
                a[j * n + j] = sqrt(sum);
            } else {
                return 0;
            }
        }
    }
    return 1;
}

/* The unit vector (n + 1) across n rows (n, n + 1), which are used up: the last column of Q in A^T = Q R, by reflections. */
static void small_null(const int n, phi_real *rows, phi_real *null)
{
    const int m = n + 1;
    phi_real factor[SMALL_MOST];
    for (int k = 0; k < n; ++k) {
        phi_real *v = rows + k * m, square = 0;
        for (int i = k; i < m; ++i) {
            square += v[i] * v[i];
        }
        const phi_real length = v[k] < 0 ? -sqrt(square) : sqrt(square);
        factor[k] = square > 0 ? 1 / (square + fabs(v[k] * length)) : 0;
        v[k] += length;
        for (int j = k + 1; j < n; ++j) {
            phi_real dot = 0;
            for (int i = k; i < m; ++i) {
                dot += v[i] * rows[j * m + i];
            }
            for (int i = k; i < m; ++i) {
                rows[j * m + i] -= factor[k] * dot * v[i];
            }
        }
    }
    for (int i = 0; i < m; ++i) {
        null[i] = i == n;
    }
    for (int k = n - 1; k >= 0; --k) {
        phi_real dot = 0;
        for (int i = k; i < m; ++i) {
            dot += rows[k * m + i] * null[i];
        }
        for (int i = k; i < m; ++i) {
            null[i] -= factor[k] * dot * rows[k * m + i];
        }
    }
}

/* +- the smallest singular value of a square matrix, its sign that of the determinant: by plane rotations that make its columns
 * orthogonal. The matrix is used up; NaN where it is no numbers. */
static phi_real small_signed(const int n, phi_real *a)
{
    phi_real copy[SMALL_MOST * SMALL_MOST], square = 0;
    for (int i = 0; i < n * n; ++i) {
        copy[i] = a[i];
        square += a[i] * a[i];
    }
    if (!(square - square >= 0)) {
        return square - square;
    }
    const int sign = small_solve(n, copy, 0, copy);
    for (int sweep = 0, turned = 1; turned && sweep < SMALL_SWEEPS; ++sweep) {
        turned = 0;
        for (int i = 0; i < n; ++i) {
            for (int j = i + 1; j < n; ++j) {
                phi_real first = 0, second = 0, dot = 0;
                for (int k = 0; k < n; ++k) {
                    first += a[k * n + i] * a[k * n + i];
                    second += a[k * n + j] * a[k * n + j];
                    dot += a[k * n + i] * a[k * n + j];
                }
                if (!(fabs(dot) > SMALL_NOTHING * sqrt(first * second))) {
                    continue;
                }
                turned = 1;
                const phi_real half = (second - first) / (2 * dot), root = sqrt(1 + half * half);
                const phi_real t = half < 0 ? -1 / (root - half) : 1 / (root + half), c = 1 / sqrt(1 + t * t), s = t * c;
                for (int k = 0; k < n; ++k) {
                    const phi_real kept = a[k * n + i];
                    a[k * n + i] = c * kept - s * a[k * n + j];
                    a[k * n + j] = s * kept + c * a[k * n + j];
                }
            }
        }
    }
    phi_real least = HUGE_VAL;
    for (int j = 0; j < n; ++j) {
        phi_real column = 0;
        for (int k = 0; k < n; ++k) {
            column += a[k * n + j] * a[k * n + j];
        }
        least = column < least ? column : least;
    }
    return sign * sqrt(least);
}

/* Eigenvalues of a square matrix, which is used up: to Hessenberg's form by reflections, then double shifts (Francis, 1961). How many were found comes back. */
static int small_eigenvalues(const int n, phi_real *a, phi_real *re, phi_real *im)
{
    phi_real size = 0;
    for (int i = 0; i < n * n; ++i) {
        size += fabs(a[i]);
    }
    if (!(size - size >= 0)) {
        return 0;
    }
    for (int k = 0; k + 2 < n; ++k) {
        phi_real v[SMALL_MOST], square = 0;
        for (int i = k + 1; i < n; ++i) {
            v[i] = a[i * n + k];
            square += v[i] * v[i];
        }
        if (!(square > v[k + 1] * v[k + 1])) {
            continue;
        }
        v[k + 1] += v[k + 1] < 0 ? -sqrt(square) : sqrt(square);
        square = 0;
        for (int i = k + 1; i < n; ++i) {
            square += v[i] * v[i];
        }
        for (int j = 0; j < n; ++j) {
            phi_real dot = 0;
            for (int i = k + 1; i < n; ++i) {
                dot += v[i] * a[i * n + j];
            }
            for (int i = k + 1; i < n; ++i) {
                a[i * n + j] -= 2 * dot / square * v[i];
            }
        }
        for (int j = 0; j < n; ++j) {
            phi_real dot = 0;
            for (int i = k + 1; i < n; ++i) {
                dot += v[i] * a[j * n + i];
            }
            for (int i = k + 1; i < n; ++i) {
                a[j * n + i] -= 2 * dot / square * v[i];
            }
        }
        for (int i = k + 2; i < n; ++i) {
            a[i * n + k] = 0;
        }
    }
    for (int high = n - 1, turn = 0; high >= 0;) {
        int low = high;
        for (; low > 0; --low) {
            const phi_real near = fabs(a[(low - 1) * n + low - 1]) + fabs(a[low * n + low]);
            if (fabs(a[low * n + low - 1]) <= SMALL_NOTHING * (near > 0 ? near : size)) {
                break;
            }
        }
        const phi_real x = a[high * n + high];
        if (low == high) {
            re[high] = x;
            im[high--] = 0;
            turn = 0;
            continue;
        }
        const phi_real y = a[(high - 1) * n + high - 1], w = a[high * n + high - 1] * a[(high - 1) * n + high];
        if (low == high - 1) {
            const phi_real half = (y - x) / 2, under = half * half + w, root = sqrt(fabs(under));
            if (under >= 0) {
                const phi_real far = half < 0 ? half - root : half + root;
                re[high - 1] = x + far;
                re[high] = far < 0 || far > 0 ? x - w / far : x;
                im[high - 1] = im[high] = 0;
            } else {
                re[high - 1] = re[high] = x + half;
                im[high - 1] = root;
                im[high] = -root;
            }
            high -= 2;
            turn = 0;
            continue;
        }
        if (turn++ == SMALL_SWEEPS) {
            return n - 1 - high;
        }
        /* The first column of (A - x)(A - y) - w, or of shifts out of the way where the usual ones go round. */
        const int is_odd = turn % 10 == 0;
        const phi_real off = is_odd ? fabs(a[high * n + high - 1]) + fabs(a[(high - 1) * n + high - 2]) : 0;
        const phi_real sum = is_odd ? 1.5 * off : x + y, product = is_odd ? off * off : x * y - w;
        const phi_real *head = a + low * n + low;
        phi_real p = head[0] * (head[0] - sum) + product + head[1] * head[n], q = head[n] * (head[0] + head[n + 1] - sum), r = head[n] * head[2 * n + 1];
        for (int k = low; k < high; ++k) {
            const int few = k + 2 <= high ? 3 : 2;
            if (k > low) {
                p = a[k * n + k - 1];
                q = a[(k + 1) * n + k - 1];
                r = few == 3 ? a[(k + 2) * n + k - 1] : 0;
            }
            const phi_real largest = fabs(p) + fabs(q) + fabs(r);
            if (!(largest > 0)) {
                continue;
            }
            phi_real v[3] = {p / largest, q / largest, few == 3 ? r / largest : 0};
            const phi_real length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
            v[0] += v[0] < 0 ? -length : length;
            const phi_real scale = 2 / (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
            for (int j = 0; j < n; ++j) {
                phi_real dot = 0;
                for (int i = 0; i < few; ++i) {
                    dot += v[i] * a[(k + i) * n + j];
                }
                for (int i = 0; i < few; ++i) {
                    a[(k + i) * n + j] -= scale * dot * v[i];
                }
            }
            for (int j = 0; j < n; ++j) {
                phi_real dot = 0;
                for (int i = 0; i < few; ++i) {
                    dot += v[i] * a[j * n + k + i];
                }
                for (int i = 0; i < few; ++i) {
                    a[j * n + k + i] -= scale * dot * v[i];
                }
            }
            for (int i = 1; i < few && k > low; ++i) {
                a[(k + i) * n + k - 1] = 0;
            }
        }
    }
    return n;
}
