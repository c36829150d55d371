/* Where places of the page lie in a picture. */
#include "kernel.h"

int bounds_of(const Places *places, const double warp[9], double bounds[4]) {
    int ahead = 0, behind = 0;
    for (int k = 0; k < 4; k++) {
        double x = places->hull[2 * k], y = places->hull[2 * k + 1];
        double w = warp[6] * x + warp[7] * y + warp[8];
        double u = (warp[0] * x + warp[1] * y + warp[2]) / w, v = (warp[3] * x + warp[4] * y + warp[5]) / w;
        ahead += w > 0;
        behind += w < 0;
        if (!(u > -1e9 && u < 1e9 && v > -1e9 && v < 1e9)) return 0;
        if (k == 0 || u < bounds[0]) bounds[0] = u;
        if (k == 0 || v < bounds[1]) bounds[1] = v;
        if (k == 0 || u > bounds[2]) bounds[2] = u;
        if (k == 0 || v > bounds[3]) bounds[3] = v;
    }
    return ahead == 4 || behind == 4;
}

Mapping mapping_of(const Places *places, const double warp[9], int32_t left, int32_t top) {
    Mapping found = {{0}, left, top};
    double corner[3] = {left, top, 0};
    for (int row = 0; row < 3; row++) {
        double m[3];
        for (int k = 0; k < 3; k++) m[k] = warp[3 * row + k] - corner[row] * warp[6 + k];
        found.a[3 * row] = (float)m[0];
        found.a[3 * row + 1] = (float)m[1];
        found.a[3 * row + 2] = (float)(m[0] * places->middle[0] + m[1] * places->middle[1] + m[2]);
    }
    return found;
}

void mapped(const Places *places, const Mapping *mapping, int32_t first, int32_t count, float *x, float *y) {
    const float *a = mapping->a, *across = places->across + first, *down = places->down + first;
    for (int32_t k = 0; k < count; k++) {
        const float near = 1 / (a[6] * across[k] + a[7] * down[k] + a[8]);
        x[k] = (a[0] * across[k] + a[1] * down[k] + a[2]) * near;
        y[k] = (a[3] * across[k] + a[4] * down[k] + a[5]) * near;
    }
}

int is_inside(const Picture *picture, const Places *places, const double warp[9], const double bounds[4]) {
    double least = 0, most = 0;
    for (int k = 0; k < 4; k++) {
        const double w = warp[6] * places->hull[2 * k] + warp[7] * places->hull[2 * k + 1] + warp[8], size = w < 0 ? -w : w;
        if (k == 0 || size < least) least = size;
        if (k == 0 || size > most) most = size;
    }
    return picture->width <= MOST_SIDE && picture->height <= MOST_SIDE && most < MOST_DEPTH * least && least > 1e-20 &&
           most < 1e20 && bounds[0] >= 1 && bounds[1] >= 1 && bounds[2] < picture->width - 2 && bounds[3] < picture->height - 2;
}
