/* Registering the printed page on a picture: the whole loop of `tracking/registration.py`, which says what it means.
 *
 * Source: inverse compositional alignment (Baker and Matthews, Lucas-Kanade 20 Years On, 2004), with each patch's own
 *   gain and offset of brightness.
 */
#include "kernel.h"

static double magnitude(double value) { return value < 0 ? -value : value; }

/* Brightness at the print's places; 0 where they are not within the picture, four pixels around each. */
static int sampled(const Picture *picture, const Places *places, const double warp[9], float *values) {
    double at[4];
    if (!bounds_of(places, warp, at)) return 0;
    if (!(at[0] >= 0 && at[1] >= 0 && at[2] < picture->width - 1 && at[3] < picture->height - 1)) return 0;
    const int32_t left = (int32_t)at[0], top = (int32_t)at[1];
    const Mapping mapping = mapping_of(places, warp, left, top);
    const uint8_t *corner = picture->rows + top * picture->stride + left;
    const float *levels = picture->levels;
    /* Rounding may take a place at the picture's border over it. */
    const int inside = is_inside(picture, places, warp, at);
    const float most_x = (float)(picture->width - 2 - left), most_y = (float)(picture->height - 2 - top);
    for (int32_t first = 0; first < places->count; first += BLOCK) {
        const int32_t count = places->count - first < BLOCK ? places->count - first : BLOCK;
        float x[BLOCK], y[BLOCK], a[BLOCK], b[BLOCK], c[BLOCK], d[BLOCK];
        int32_t pixel_x[BLOCK], pixel_y[BLOCK];
        mapped(places, &mapping, first, count, x, y);
        if (inside) split(x, y, pixel_x, pixel_y, count);
        for (int32_t k = 0; k < count && !inside; k++) {
            float within_x = x[k] > 0 ? x[k] : 0, within_y = y[k] > 0 ? y[k] : 0;
            pixel_x[k] = (int32_t)(within_x < most_x ? within_x : most_x);
            pixel_y[k] = (int32_t)(within_y < most_y ? within_y : most_y);
            x[k] = within_x - (float)pixel_x[k];
            y[k] = within_y - (float)pixel_y[k];
        }
        for (int32_t k = 0; k < count; k++) {
            const uint32_t four = four_pixels(corner, picture->stride, pixel_x[k], pixel_y[k]);
            a[k] = levels[four & 255];
            b[k] = levels[four >> 8 & 255];
            c[k] = levels[four >> 16 & 255];
            d[k] = levels[four >> 24];
        }
        for (int32_t k = 0; k < count; k++) {
            const float above = a[k] + x[k] * (b[k] - a[k]), below = c[k] + x[k] * (d[k] - c[k]);
            values[first + k] = above + y[k] * (below - above);
        }
    }
    return 1;
}

/* A patch that a thumb covers in part is hidden; only a frame has enough patches to leave some out. */
static void leave_covered_out(const Print *print, const Rules *rules, const double *share, int32_t *seen) {
    if (print->patches <= print->squares) return;
    double left[MOST_PATCHES], sorted[MOST_PATCHES];
    for (int32_t k = 0; k < print->patches; k++) {
        if (!(share[k] > -2)) return; /* no brightness at all in a patch */
        left[k] = 1 - share[k] * share[k];
        int32_t at = k;
        for (; at > 0 && sorted[at - 1] > left[k]; at--) sorted[at] = sorted[at - 1];
        sorted[at] = left[k];
    }
    const double usual = rules->covered_left_ratio * sorted[print->patches / 2];
    const double most = usual > rules->covered_left ? usual : rules->covered_left;
    for (int32_t k = 0; k < print->patches; k++) seen[k] = seen[k] && left[k] <= most;
}

/* Picture against print, patch by patch; the values are turned into those about each patch's mean. */
static void compare(const Print *print, const Rules *rules, float *values, Comparison *found) {
    ANY_ORDER
    double along[MOST_PATCHES], most[MOST_PATCHES], share[MOST_PATCHES], explained = 0, whole = 0;
    found->contrast = -1e300;
    for (int32_t k = 0; k < print->patches; k++) {
        const int32_t first = print->first[k], count = print->first[k + 1] - first;
        float *own = values + first;
        const float *printed = print->printed + first;
        float sum = 0, product = 0, square = 0;
        for (int32_t n = 0; n < count; n++) sum += own[n];
        const float mean = sum / (float)count;
        for (int32_t n = 0; n < count; n++) {
            own[n] -= mean;
            product += own[n] * printed[n];
            square += own[n] * own[n];
        }
        along[k] = product;
        most[k] = __builtin_sqrt(print->power[k] * (double)square);
        share[k] = most[k] > 0 ? along[k] / most[k] : -3;
        found->mean[k] = mean;
        found->gain[k] = along[k] / print->power[k];
        /* A washed-out marker must not be scaled up to full contrast. */
        found->seen[k] = found->gain[k] > rules->min_gain && along[k] >= print->least_correlation * most[k];
        if (found->gain[k] > found->contrast) found->contrast = found->gain[k];
    }
    leave_covered_out(print, rules, share, found->seen);
    for (int32_t k = 0; k < print->patches; k++) {
        explained += found->seen[k] ? along[k] : 0;
        whole += found->seen[k] ? most[k] : 0;
    }
    found->correlation = whole > 0 ? explained / whole : 0;
}

/* Whether the visible patches hold the page: enough of them, and one of each side of a frame. */
static int enough(const Print *print, const int32_t *seen) {
    int32_t count = 0;
    for (int32_t k = 0; k < print->patches; k++) {
        int shown = print->side[k] < 0;
        for (int32_t n = 0; n < print->patches; n++) shown |= seen[n] && print->side[n] == print->side[k];
        if (!shown) return 0;
        count += seen[k];
    }
    return count >= print->least_seen;
}

/* Solve A x = b, A (8, 8) positive definite, in place; 0 where it is not.  Source: Cholesky. */
static int solve(double a[64], double b[8]) {
    for (int i = 0; i < 8; i++) {
        for (int j = 0; j <= i; j++) {
            double left = a[8 * i + j];
            for (int k = 0; k < j; k++) left -= a[8 * i + k] * a[8 * j + k];
            if (i != j) a[8 * i + j] = left / a[8 * j + j];
            else if (left > 1e-15 * a[8 * i + i]) a[8 * i + i] = __builtin_sqrt(left);
            else return 0;
        }
    }
    for (int i = 0; i < 8; i++) {
        for (int k = 0; k < i; k++) b[i] -= a[8 * i + k] * b[k];
        b[i] /= a[8 * i + i];
    }
    for (int i = 7; i >= 0; i--) {
        for (int k = i + 1; k < 8; k++) b[i] -= a[8 * k + i] * b[k];
        b[i] /= a[8 * i + i];
    }
    return 1;
}

/* Change of the warp's eight parameters that takes most of the residual of the asked patches away. */
static int step_of(const Print *print, const Rules *rules, const float *values, const double *gain, const int32_t *asked,
                   double step[8]) {
    ANY_ORDER
    double normal[64] = {0};
    for (int row = 0; row < 8; row++) step[row] = 0;
    for (int32_t k = 0; k < print->patches; k++) {
        if (!asked[k]) continue;
        for (int n = 0; n < 64; n++) normal[n] += print->normal[64 * k + n];
        if (!(gain[k] > rules->min_gain)) continue;
        for (int row = 0; row < 8; row++) {
            const float *free = print->free + (int64_t)row * print->places.count;
            float sum = 0;
            for (int32_t n = print->first[k]; n < print->first[k + 1]; n++) sum += free[n] * values[n];
            step[row] += (double)sum / gain[k];
        }
    }
    return solve(normal, step);
}

/* The warp after a step of its parameters, h33 = 1; 0 where the step folds the page. */
static int stepped(double warp[9], const double s[8]) {
    const double a = 1 + s[0], b = s[1], c = s[2], d = s[3], e = 1 + s[4], f = s[5], g = s[6], h = s[7];
    const double back[9] = {e - f * h, c * h - b, b * f - c * e, f * g - d, a - c * g, c * d - a * f,
                            d * h - e * g, b * g - a * h, a * e - b * d};
    double moved[9];
    if (a * back[0] + b * back[3] + c * back[6] == 0) return 0;
    for (int row = 0; row < 3; row++)
        for (int k = 0; k < 3; k++)
            moved[3 * row + k] = warp[3 * row] * back[k] + warp[3 * row + 1] * back[3 + k] + warp[3 * row + 2] * back[6 + k];
    for (int k = 0; k < 9; k++) warp[k] = moved[k] / moved[8];
    return 1;
}

/* How far a step moves the page, px. */
static double length_px(const Print *print, const double step[8]) {
    double longest = 0;
    for (int k = 0; k < 8; k++) longest = magnitude(step[k]) > longest ? magnitude(step[k]) : longest;
    return longest * print->extent_px;
}

static int is_settled(const Print *print, const Rules *rules, const double step[8]) {
    return rules->left_share * length_px(print, step) < rules->stop_px;
}

/* From a warp that some patches do not fit to one that all agree on; 0 where there is none. */
static int with_all(const Picture *picture, const Print *print, const Rules *rules, double warp[9], float *values,
                    Comparison *found) {
    int32_t every[MOST_PATCHES];
    double step[8];
    for (int32_t k = 0; k < print->patches; k++) every[k] = 1;
    for (int32_t steps = 0; steps < rules->bent_steps; steps++) {
        if (!sampled(picture, &print->places, warp, values)) return 0;
        found->steps++;
        compare(print, rules, values, found);
        int32_t all = 1;
        for (int32_t k = 0; k < print->patches; k++) all &= found->seen[k];
        if (steps >= rules->bent_seen_steps && !all) return 0;
        if (!step_of(print, rules, values, found->gain, every, step)) return 0;
        if (is_settled(print, rules, step)) return all;
        if (!stepped(warp, step)) return 0;
    }
    return 0;
}

PUBLIC int32_t kernel_version(void) { return KERNEL_VERSION; }

/* Brightness of a picture at places under a warp, values (count,); returns 0 where they are not all within it. */
PUBLIC int32_t kernel_values(const Picture *picture, const Places *places, const double *warp, float *values) {
    return sampled(picture, places, warp, values);
}

/* Compare the print with a picture under a warp.  values (samples,): what the picture has beyond the print, in units of
 * its contrast.  Returns 0 where the page is not within the picture. */
PUBLIC int32_t kernel_compare(const Picture *picture, const Print *print, const Rules *rules, const double *warp,
                              float *values, Comparison *found) {
    found->steps = 1;
    if (!sampled(picture, &print->places, warp, values)) return 0;
    compare(print, rules, values, found);
    for (int32_t k = 0; k < print->patches; k++) {
        const float gain = (float)found->gain[k];
        for (int32_t n = print->first[k]; n < print->first[k + 1]; n++)
            values[n] = gain > rules->min_gain ? values[n] / gain - print->printed[n] : 0;
    }
    return 1;
}

/* Bring a warp near by a few steps with a coarse print, until one is shorter than `near_px`; where none is, or too few
 * patches are visible there, the warp stays as it is.
 * Returns how many steps were taken. */
int32_t come_near(const Picture *picture, const Print *print, const Rules *rules, double near_px, double warp[9],
                  float *values, Comparison *found) {
    int32_t every[MOST_PATCHES], steps = 0;
    double step[8], moved[9];
    for (int32_t k = 0; k < print->patches; k++) every[k] = 1;
    for (int k = 0; k < 9; k++) moved[k] = warp[k];
    while (steps < COARSE_STEPS) {
        if (!sampled(picture, &print->places, moved, values)) return steps;
        steps++;
        compare(print, rules, values, found);
        if (!step_of(print, rules, values, found->gain, enough(print, found->seen) ? found->seen : every, step)) break;
        if (!stepped(moved, step)) break;
        if (!(length_px(print, step) < near_px)) continue;
        /* Steps may also become short where a few patches fit at a false place. */
        if (!enough(print, found->seen)) break;
        for (int k = 0; k < 9; k++) warp[k] = moved[k];
        break;
    }
    return steps;
}

/* Refine a warp on a picture.  values (samples,): room to work in.  Returns 0 where the page does not match, 2 where the
 * visible patches do not hold it. */
PUBLIC int32_t kernel_register(const Picture *picture, const Print *print, const Rules *rules, double *warp,
                               float *values, Comparison *found) {
    int32_t every[MOST_PATCHES];
    double step[8], bent_warp[9];
    found->steps = 0;
    for (int32_t k = 0; k < print->patches; k++) every[k] = 1;
    for (int32_t steps = 0; steps <= 2 * rules->max_steps; steps++) {
        if (!sampled(picture, &print->places, warp, values)) return 0;
        found->steps++;
        compare(print, rules, values, found);
        const int holds = enough(print, found->seen);
        /* A page that is found but still moves goes on: where it is stopped, a marker may be off by a pixel. */
        const int there = found->correlation >= rules->min_correlation && holds;
        if (steps == 2 * rules->max_steps || (steps == rules->max_steps && !there)) break;
        int any = 0;
        for (int32_t k = 0; k < print->patches; k++) any |= found->seen[k];
        if (steps == rules->hopeless_steps && !any) return 0;
        /* Far from the right place all markers match badly; then all of them are used for the step. */
        if (!step_of(print, rules, values, found->gain, holds ? found->seen : every, step)) return 0;
        if (!stepped(warp, step)) return 0;
        if (is_settled(print, rules, step)) break;
    }
    int all = 1;
    for (int32_t k = 0; k < print->patches; k++) all &= found->seen[k];
    if (!all) {
        Comparison bent = *found;
        for (int k = 0; k < 9; k++) bent_warp[k] = warp[k];
        const int agreed = with_all(picture, print, rules, bent_warp, values, &bent);
        found->steps = bent.steps;
        if (agreed) {
            *found = bent;
            for (int k = 0; k < 9; k++) warp[k] = bent_warp[k];
        }
    }
    return enough(print, found->seen) ? 1 : 2;
}

/* What of the print's changes no gain or offset of brightness could make.
 * gradient (2, samples): of the print, per unit of the places; free (8, samples) and normal (patches, 8, 8): as in
 * `Print`, written.  Source: `print_template.warp_jacobian`, `without_gains`. */
PUBLIC void kernel_free(const Print *print, const float *gradient, float *free, double *normal) {
    ANY_ORDER
    const int32_t samples = print->places.count;
    const float *gx = gradient, *gy = gradient + samples;
    const float across = (float)print->places.middle[0], down = (float)print->places.middle[1];
    for (int32_t n = 0; n < samples; n++) {
        const float x = across + print->places.across[n], y = down + print->places.down[n];
        const float inward = gx[n] * x + gy[n] * y;
        const float row[8] = {gx[n] * x, gx[n] * y, gx[n], gy[n] * x, gy[n] * y, gy[n], -inward * x, -inward * y};
        for (int k = 0; k < 8; k++) free[(int64_t)k * samples + n] = row[k];
    }
    for (int32_t k = 0; k < print->patches; k++) {
        const int32_t first = print->first[k], end = print->first[k + 1];
        for (int row = 0; row < 8; row++) {
            float *own = free + (int64_t)row * samples, sum = 0, product = 0;
            for (int32_t n = first; n < end; n++) {
                sum += own[n];
                product += own[n] * print->printed[n];
            }
            const float mean = sum / (float)(end - first);
            const float share = print->power[k] > 0 ? product / (float)print->power[k] : 0;
            for (int32_t n = first; n < end; n++) own[n] -= mean + share * print->printed[n];
        }
        for (int i = 0; i < 8; i++)
            for (int j = 0; j <= i; j++) {
                const float *one = free + (int64_t)i * samples, *other = free + (int64_t)j * samples;
                float sum = 0;
                for (int32_t n = first; n < end; n++) sum += one[n] * other[n];
                normal[64 * k + 8 * i + j] = normal[64 * k + 8 * j + i] = sum;
            }
    }
}
