/* What a call of the brake orbits' stencils is given and tells: numbers of one type, in the order that `native/flows/brake.py` says, too. */
enum {
    DESK_Q = PHI_Q,
    DESK_LINKS = PHI_Q - PHI_CART,
    DESK_ALL = PHI_Q + 1,
    DESK_KNOWN = 8,         /* places that a curve is touched at */
    DESK_CORRECTIONS = 16,  /* that are told */
    DESK_ASKED = 1024,      /* evaluations that are told */
    DESK_WATCHED = 24,      /* test functions */
    DESK_ROWS = 64,         /* orbits of one call */
    DESK_TRIES = 16,        /* orbits on the way to a zero */
    DESK_EVENTS = 24,       /* zeros of one call */
    DESK_ZEROS = 16,        /* zeros of one step */
    DESK_LINE = 24,         /* places of a curve that is known between two points */
    DESK_OUTSIDE = 4,       /* values outside a bracket */
    DESK_SHAPE = 8          /* places beside one where [J; t] is singular, and coefficients of the polynomial through them */
};

/* What is known of one orbit: y = (q_0, omega) / scale. */
typedef struct brake_orbit {
    phi_real relative, converged, is_whole, is_told, taken;
    phi_real sigma, brake_loss, odd_loss, unequal_brakes, error, energy; /* of the bordered Jacobian; test functions; of omega; NaN where none is emitted */
    phi_real largest_kappa, energy_slope, steepness;                     /* |kappa|; dV . t; |dV| |theta| / 2 V */
    phi_real y[DESK_ALL], tangent[DESK_ALL], residual[DESK_Q], jacobian[DESK_Q][DESK_ALL], corrections[DESK_CORRECTIONS];
    phi_real a[DESK_LINKS][DESK_LINKS], b[DESK_LINKS][DESK_LINKS], c[DESK_LINKS][DESK_LINKS], d[DESK_LINKS][DESK_LINKS];
    phi_real rate[DESK_LINKS], force[DESK_LINKS], slope[DESK_LINKS], noise[DESK_Q];
    phi_real folded[DESK_LINKS * DESK_LINKS]; /* d^T a across the force: its first (N - 1)^2 numbers */
} brake_orbit;

/* One that a run found: where it is, the step to try behind it, and the test functions there. */
typedef struct brake_row {
    phi_real arclength, step, values[DESK_WATCHED];
    brake_orbit orbit;
} brake_row;

/* The zero of a test function that a run met: before which of its rows, which function, what is left of it, and the orbit there. */
typedef struct brake_event {
    phi_real before, which, arclength, left, y[DESK_ALL], folded[DESK_LINKS * DESK_LINKS];
} brake_event;

typedef struct brake_desk {
    phi_real scale[DESK_ALL], tolerance, rough, most_steps;     /* of the problem: sizes, the flow's tolerances and its budget */
    phi_real tol, trust, most_corrections, is_place;            /* of Newton's iteration; whether the place alone is wanted, and no columns there */
    phi_real guess[DESK_ALL], normal[DESK_ALL];                 /* where it begins, and across what it stays */
    phi_real count, place, axis[DESK_ALL], known[DESK_KNOWN][2][DESK_ALL]; /* of the curve: places and tangents */
    phi_real before_jacobian[DESK_Q][DESK_ALL], before_tangent[DESK_ALL];  /* of the orbit before */
    phi_real moved, shifted, turned, changed, change[DESK_ALL][DESK_ALL];   /* told: from the orbit before, from the guess, cosine; of its Jacobian */
    phi_real evaluations, asked[DESK_ASKED][DESK_ALL + 2];      /* told: q_0, omega, tolerance, how many columns */
    brake_orbit orbit;
    phi_real transition[2 * DESK_Q * 2 * DESK_LINKS], rates[DESK_Q], steps; /* of the last evaluation with columns */
    phi_real step, step_min, step_max, max_angle, aim_angle, max_change, wanted; /* of a run: the step to try, its limits, and how many orbits */
    phi_real since, start[2][DESK_ALL];                         /* orbits since the run's start, and that with its tangent */
    phi_real watched, watch[DESK_WATCHED][5];                   /* test functions: what, which, less how much, how it may dip, whether a run passes its zeros */
    phi_real seen, at[DESK_KNOWN], values[DESK_KNOWN][DESK_WATCHED], sigmas[DESK_KNOWN]; /* of the places known: how many have values; arclength, values, sigma */
    phi_real zero_count, zeros[DESK_ZEROS][2];                  /* known in the last step: of which test function, and where */
    phi_real taken, stopped, doubtful, met;                     /* told: how many orbits, why no more, whether more than signs show may lie in the last step but one, and how many zeros on the way */
    brake_row rows[DESK_ROWS];
    brake_event events[DESK_EVENTS];
    phi_real tried;                                             /* told: how many orbits on the way to a zero */
    brake_row tries[DESK_TRIES];
    phi_real line_count, line_at[DESK_LINE], line[DESK_LINE][2][DESK_ALL]; /* of a curve: places and tangents in order, its two ends before them */
    phi_real line_values[2], outside_count, outside[DESK_OUTSIDE][2];      /* of a test function: values at the ends; places beyond, and values */
    phi_real placed[DESK_SHAPE][DESK_ALL + 1];                   /* places of a curve that are wanted: arclengths, and told */
    phi_real shape_centre, shape_half, shape[DESK_SHAPE][DESK_ALL]; /* the polynomial over (s - centre) / half that the curve is there; none where half is 0 */
    phi_real line_spacing, line_near, line_settle, line_regular; /* how far off the zero may be; how far from an orbit that is told; |sigma| below which no other is guessed from it */
} brake_desk;

#define SMALL_MOST DESK_ALL
#define SMALL_SWEEPS 40
#define SMALL_NOTHING 1e-16
#define TOUCH_SIZE DESK_ALL
#define TOUCH_MOST DESK_KNOWN
#define RUN_TOUCHED 5    /* places that a run's next guess leans on */
#define RUN_SEEN 0.2     /* changes of the Jacobian below which nothing singular is near */
#define RUN_HOPELESS 1.1 /* changes at the guess, in those allowed, from which on the step is not worth going on with */
#define TOUCH_TURNED 0.5 /* cosine of tangent and axis below which a point is too far round a bend to say anything */
#define TOUCH_APART 0.1  /* distance of two points, in that from the place, below which the farther one adds nothing */
#define BRAKE_HALF_PI 1.57079632679489661923
#define BRAKE_EPSILON 0x1p-52
#define BRAKE_ROUNDING 1e-15 /* corrections, in units of 1 + |y|, that are not worth taking */
#define BRAKE_LEFT 1e-16     /* what is thought to be left, and not worth a correction */
#define BRAKE_DOUBTFUL 1e-13 /* those that are more than rounding, where less was thought to be left */
#define BRAKE_FLOOR 1e-2     /* what rough columns leave, in units of their tolerance */
#define BRAKE_CLEAR 1e-6     /* of the distance of a singular matrix, what rough columns may leave */
#define BRAKE_FAR 1e-5       /* corrections above which rough columns serve again */
#define BRAKE_SETTLED 1e-9   /* corrections that leave the columns as good as those of the place */
#define ZERO_SETTLED 1e-14  /* corrections after which the columns at a zero are asked for once more */
#define BRAKE_FRESH 1e-3     /* share of its own that a correction may leave because its columns are of another place */
