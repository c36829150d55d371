/* A page registered from where it is expected. */
#include "kernel.h"

/* A print, and room to register it: `values` (samples,).  `coarse`, null for none: some of its samples, with which a page
 * is brought near, by steps until one is shorter than `near_px`; `coarse_steps`, written: those that took.  The print's
 * places are page mm less `middle`, over `extent`. */
typedef struct {
    const Print *print, *coarse;
    const Rules *rules;
    float *values;
    Comparison *found;
    double middle[2], extent, near_px;
    int32_t coarse_steps;
} Drawing;

enum { NONE = 0, HELD = 1, LOOSE = 2, ALL_SEEN = 4 };

/* Follow a page: expected (9,), the start of its registration; page (9,), what is found.  Homographies are page mm -> px,
 * h33 = 1.  Returns what was found. */
PUBLIC int32_t kernel_follow(const Picture *picture, Drawing *drawing, const double *expected, double *page) {
    const double *middle = drawing->middle, extent = drawing->extent;
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
    return state | (all ? ALL_SEEN : 0);
}
