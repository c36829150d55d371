/* A print that moved while it was exposed: means of its drawing along the motion (`tracking/print_template.py`). */
#include "kernel.h"

/* means (rows, columns): of a drawing, less `steps` shares of the motion from half of it before to half of it after, in
 * samples.  phases (2, 2, height, width): the drawing at whole and at half samples down and across; sample (0, 0) of the
 * means is (top, left) of it.  A motion that leaves it ends at its border. */
PUBLIC void kernel_smeared(const float *phases, int32_t width, int32_t height, int32_t left, int32_t top, int32_t rows,
                           int32_t columns, double motion_x, double motion_y, int32_t steps, float *means) {
    /* The last half samples have no neighbour, so one row and one column are never the first of two. */
    const double first_x = 2 * left, most_x = 2 * (width - columns) - 2, first_y = 2 * top, most_y = 2 * (height - rows) - 2;
    const int64_t plane = (int64_t)width * height;
    for (int64_t k = 0; k < (int64_t)rows * columns; k++) means[k] = 0;
    for (int32_t step = 0; step < steps; step++) {
        const double share = (step + 0.5) / steps - 0.5;
        double x = first_x - 2 * motion_x * share, y = first_y - 2 * motion_y * share;
        x = x > 0 ? x : 0;
        y = y > 0 ? y : 0;
        x = x < most_x ? x : most_x;
        y = y < most_y ? y : most_y;
        const int32_t column = (int32_t)x, row = (int32_t)y;
        const float right = (float)(x - column), down = (float)(y - row);
        const float weight[4] = {(1 - down) * (1 - right) / steps, (1 - down) * right / steps, down * (1 - right) / steps,
                                 down * right / steps};
        const float *four[4];
        for (int32_t k = 0; k < 4; k++) {
            const int32_t across = column + k % 2, below = row + k / 2;
            four[k] = phases + (2 * (below % 2) + across % 2) * plane + (int64_t)(below / 2) * width + across / 2;
        }
        for (int32_t line = 0; line < rows; line++) {
            const float *a = four[0] + (int64_t)line * width, *b = four[1] + (int64_t)line * width;
            const float *c = four[2] + (int64_t)line * width, *d = four[3] + (int64_t)line * width;
            float *mean = means + (int64_t)line * columns;
            for (int32_t k = 0; k < columns; k++)
                mean[k] += weight[0] * a[k] + weight[1] * b[k] + weight[2] * c[k] + weight[3] * d[k];
        }
    }
}
