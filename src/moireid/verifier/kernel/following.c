/* A page followed from one frame to the next in one call: where it is expected, its registration, and its rows. */
#include "kernel.h"

/* A print, and room to register it: `values` (samples,).  `coarse`, null for none: some of its samples, with which a page
 * is brought near, by steps until one is shorter than `near_px`; `coarse_steps`, written: those that took.  The print's places are page mm less `middle`, over `extent`;
 * it serves pages of `least_scale` to `most_scale`, px per mm at its middle. */
typedef struct {
    const Print *print, *coarse;
    const Rules *rules;
    float *values;
    Comparison *found;
    double middle[2], extent, least_scale, most_scale, near_px;
    int32_t coarse_steps;
} Drawing;

/* Rows of the page, as `kernel_rows` reads them, where a page correlates by so much; light (256,): of each byte. */
typedef struct {
    Places places;
    const int32_t *counts;
    const float *light;
    float *profiles;
    double least_correlation;
    int32_t strips, samples;
} Rows;

enum { NONE = 0, HELD = 1, LOOSE = 2, OTHER_SCALE = 3, ALL_SEEN = 4, READ = 8 };

static double determinant(const double m[9]) {
    return m[0] * (m[4] * m[8] - m[5] * m[7]) - m[1] * (m[3] * m[8] - m[5] * m[6]) + m[2] * (m[3] * m[7] - m[4] * m[6]);
}

/* Follow a page: expected (9,), the start of its registration; page (9,), what is found.  Homographies are page mm -> px,
 * h33 = 1.  rows: null where none are read.  Returns what was found; `OTHER_SCALE` where the print must be drawn anew. */
PUBLIC int32_t kernel_follow(const Picture *picture, Drawing *drawing, const Rows *rows, const double *expected,
                             int32_t any_scale, double *page) {
    const double *middle = drawing->middle, extent = drawing->extent;
    const double depth = expected[6] * middle[0] + expected[7] * middle[1] + expected[8];
    const double area = determinant(expected) / (depth * depth * depth);
    const double scale = __builtin_sqrt(area < 0 ? -area : area);
    if (!any_scale && !(scale > drawing->least_scale && scale < drawing->most_scale)) return OTHER_SCALE;
    double warp[9];
    for (int row = 0; row < 9; row += 3) {
        warp[row] = expected[row] * extent;
        warp[row + 1] = expected[row + 1] * extent;
        warp[row + 2] = expected[row] * middle[0] + expected[row + 1] * middle[1] + expected[row + 2];
    }
    if (drawing->coarse)
        drawing->coarse_steps = come_near(picture, drawing->coarse, drawing->rules, drawing->near_px, warp, drawing->values,
                                          drawing->found);
    int32_t state = kernel_register(picture, drawing->print, drawing->rules, warp, drawing->values, drawing->found);
    if (!state) return NONE;
    double last[9];
    for (int row = 0; row < 9; row += 3) {
        last[row] = warp[row] / extent;
        last[row + 1] = warp[row + 1] / extent;
        last[row + 2] = warp[row + 2] - last[row] * middle[0] - last[row + 1] * middle[1];
    }
    for (int k = 0; k < 9; k++) {
        page[k] = last[k] / last[8];
        if (!(page[k] > -1e300 && page[k] < 1e300)) return NONE;
    }
    int32_t all = 1;
    for (int32_t k = 0; k < drawing->print->patches; k++) all &= drawing->found->seen[k];
    if (rows && rows->profiles && state == HELD && drawing->found->correlation >= rows->least_correlation) {
        Picture lit = *picture;
        lit.levels = rows->light;
        kernel_rows(&lit, &rows->places, page, rows->counts, rows->strips, rows->samples, rows->profiles);
        state |= READ;
    }
    return state | (all ? ALL_SEEN : 0);
}
