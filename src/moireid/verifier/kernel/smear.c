/* A print that moved while it was exposed: means of its fine drawing along the motion (`tracking/print_template.py`). */
#include "kernel.h"

/* means (planes, count): of each plane (height, width) at the places x, y (count,), in samples of the planes, less
 * `steps` shares of the motion from half of it before to half of it after; beyond a plane its border goes on. */
PUBLIC void kernel_smeared(const float *const *planes, int32_t number, int32_t width, int32_t height, const float *x,
                           const float *y, int32_t count, double motion_x, double motion_y, int32_t steps,
                           float *means) {
    const float most_x = (float)(width - 1), most_y = (float)(height - 1);
    for (int64_t k = 0; k < (int64_t)number * count; k++) means[k] = 0;
    for (int32_t step = 0; step < steps; step++) {
        const double share = (step + 0.5) / steps - 0.5;
        const float off_x = (float)(motion_x * share), off_y = (float)(motion_y * share);
        for (int32_t first = 0; first < count; first += BLOCK) {
            const int32_t block = count - first < BLOCK ? count - first : BLOCK;
            float right[BLOCK], down[BLOCK];
            int32_t column[BLOCK], row[BLOCK];
            for (int32_t k = 0; k < block; k++) {
                float u = x[first + k] - off_x, v = y[first + k] - off_y;
                u = u > 0 ? u : 0;
                v = v > 0 ? v : 0;
                u = u < most_x ? u : most_x;
                v = v < most_y ? v : most_y;
                column[k] = (int32_t)u < width - 2 ? (int32_t)u : width - 2;
                row[k] = (int32_t)v < height - 2 ? (int32_t)v : height - 2;
                right[k] = u - (float)column[k];
                down[k] = v - (float)row[k];
            }
            for (int32_t plane = 0; plane < number; plane++) {
                float *mean = means + (int64_t)plane * count + first;
                for (int32_t k = 0; k < block; k++) {
                    const float *upper = planes[plane] + (int64_t)row[k] * width + column[k], *lower = upper + width;
                    const float above = upper[0] + right[k] * (upper[1] - upper[0]);
                    const float below = lower[0] + right[k] * (lower[1] - lower[0]);
                    mean[k] += above + down[k] * (below - above);
                }
            }
        }
    }
    for (int64_t k = 0; k < (int64_t)number * count; k++) means[k] /= (float)steps;
}
