/* Largest of a row of angles or of rates in every lane, the cart's in lengths of the chain. */
static void stem_norm(const phi_real reach, const stem_lanes x[stem_q], stem_lanes *norm)
{
    stem_lanes largest = STEM_ZERO;
    for (int i = 0; i < stem_q; ++i) {
        stem_lanes size = STEM_SIZE(x[i]);
        if (i < stem_cart) {
            size *= 1 / reach;
        }
        largest = STEM_LARGER(size, largest);
    }
    *norm = largest;
}

/* Those of a row's angles and of its rates. */
static void stem_norms(const phi_real reach, const stem_lanes x[stem_x], stem_lanes norm[2])
{
    stem_norm(reach, x, norm);
    stem_norm(reach, x + stem_q, norm + 1);
}
