/* Brightness along strips of the page: means over rows of places, as `tracking/brightness_profiles.py` reads them. */
#include "kernel.h"

/* profiles (strips, samples): the mean of each strip's rows; counts (strips,): how many rows each has.  A row is
 * `samples` places, one strip's rows after another's.  Beyond the picture its border goes on.
 * Single precision is enough: a strip averages some hundred samples per fringe. */
PUBLIC void kernel_rows(const Picture *picture, const Places *places, const double *warp, const int32_t *counts,
                        int32_t strips, int32_t samples, float *profiles) {
    double at[4];
    int32_t left = 0, top = 0, inside = 0;
    if (bounds_of(places, warp, at)) {
        inside = is_inside(picture, places, warp, at);
        left = at[0] > 0 ? (int32_t)(at[0] < picture->width - 2 ? at[0] : picture->width - 2) : 0;
        top = at[1] > 0 ? (int32_t)(at[1] < picture->height - 2 ? at[1] : picture->height - 2) : 0;
    }
    const Mapping mapping = mapping_of(places, warp, left, top);
    const float *levels = picture->levels;
    const uint8_t *corner = picture->rows + top * picture->stride + left;
    const float low_x = (float)-left, low_y = (float)-top;
    const float most_x = (float)(picture->width - 1 - left), most_y = (float)(picture->height - 1 - top);
    const int32_t last_x = picture->width - 2 - left, last_y = picture->height - 2 - top;
    int32_t row = 0;
    for (int32_t strip = 0; strip < strips; strip++) {
        float *profile = profiles + (int64_t)strip * samples;
        for (int32_t n = 0; n < samples; n++) profile[n] = 0;
        for (int32_t end = row + counts[strip]; row < end; row++) {
            for (int32_t first = 0; first < samples; first += BLOCK) {
                const int32_t count = samples - first < BLOCK ? samples - first : BLOCK;
                float x[BLOCK], y[BLOCK];
                int32_t pixel_x[BLOCK], pixel_y[BLOCK];
                uint32_t four[BLOCK];
                mapped(places, &mapping, row * samples + first, count, x, y);
                if (inside) split(x, y, pixel_x, pixel_y, count);
                for (int32_t k = 0; k < count && !inside; k++) {
                    float u = x[k] > low_x ? x[k] : low_x, v = y[k] > low_y ? y[k] : low_y;
                    u = u < most_x ? u : most_x;
                    v = v < most_y ? v : most_y;
                    const int32_t column = (int32_t)(u - low_x) - left, line = (int32_t)(v - low_y) - top;
                    pixel_x[k] = column < last_x ? column : last_x;
                    pixel_y[k] = line < last_y ? line : last_y;
                    x[k] = u - (float)pixel_x[k];
                    y[k] = v - (float)pixel_y[k];
                }
                for (int32_t k = 0; k < count; k++)
                    four[k] = four_pixels(corner, picture->stride, pixel_x[k], pixel_y[k]);
                for (int32_t k = 0; k < count; k++) {
                    const float a = (float)(int32_t)(four[k] & 255), b = (float)(int32_t)(four[k] >> 8 & 255);
                    const float c = (float)(int32_t)(four[k] >> 16 & 255), d = (float)(int32_t)(four[k] >> 24);
                    const float above = a + x[k] * (b - a), below = c + x[k] * (d - c);
                    pixel_x[k] = (int32_t)(above + y[k] * (below - above) + 0.5f);
                }
                for (int32_t k = 0; k < count; k++) profile[first + k] += levels[pixel_x[k] & 255];
            }
        }
        for (int32_t n = 0; n < samples; n++) profile[n] /= (float)counts[strip];
    }
}
