/* Where a smeared print is: its correlation with a picture at each of some shifts (`tracking/smeared_frames.py`). */
#include "kernel.h"

/* Mean brightness of a block of `fewer` x `fewer` samples from (column, row) on, of a warp from samples to px: of four
 * places in it.  Single precision is enough: a block is found to a sample or two. */
static float block_mean(const Picture *picture, const float warp[9], float column, float row, int32_t fewer) {
    const float most_x = (float)(picture->width - 2), most_y = (float)(picture->height - 2);
    const float middle = 0.5f * (float)(fewer - 1), apart = fewer > 1 ? 0.25f * (float)fewer : 0;
    float sum = 0;
    for (int32_t n = 0; n < 4; n++) {
        const float across = column + middle + (n % 2 ? apart : -apart), down = row + middle + (n / 2 ? apart : -apart);
        const float near = 1 / (warp[6] * across + warp[7] * down + warp[8]);
        float x = (warp[0] * across + warp[1] * down + warp[2]) * near;
        float y = (warp[3] * across + warp[4] * down + warp[5]) * near;
        x = x > 0 ? x : 0;
        y = y > 0 ? y : 0;
        x = x < most_x ? x : most_x;
        y = y < most_y ? y : most_y;
        const int32_t pixel_x = (int32_t)x, pixel_y = (int32_t)y;
        const float right = x - (float)pixel_x, below = y - (float)pixel_y;
        const uint32_t four = four_pixels(picture->rows, picture->stride, pixel_x, pixel_y);
        const float a = picture->levels[four & 255], b = picture->levels[four >> 8 & 255];
        const float c = picture->levels[four >> 16 & 255], d = picture->levels[four >> 24];
        const float upper = a + right * (b - a), lower = c + right * (d - c);
        sum += upper + below * (lower - upper);
    }
    return sum / 4;
}

static void centre(float *values, int64_t count) {
    ANY_ORDER
    float sum = 0;
    for (int64_t k = 0; k < count; k++) sum += values[k];
    for (int64_t k = 0; k < count; k++) values[k] -= sum / (float)count;
}

/* Add to total (2 reach + 1, 2 reach + 1) the correlation of a print (rows, columns) shifted down and across by
 * -reach .. reach blocks of `fewer` samples; one that is opposite to its print counts as none.
 * warp: from samples of the print to px; room: (rows / fewer) x (columns / fewer), the same with 2 reach more each, two
 * such rows, and three rows of total. */
PUBLIC void kernel_correlations(const Picture *picture, const double *warp, const float *printed, int32_t rows,
                                int32_t columns, int32_t fewer, int32_t reach, float *room, float *total) {
    ANY_ORDER
    const int32_t height = rows / fewer, width = columns / fewer, side = 2 * reach + 1;
    const int32_t tall = height + 2 * reach, wide = width + 2 * reach;
    float *print = room, *seen = room + (int64_t)height * width, power = 0;
    for (int32_t row = 0; row < height; row++)
        for (int32_t column = 0; column < width; column++) {
            float sum = 0;
            for (int32_t n = 0; n < fewer * fewer; n++)
                sum += printed[(int64_t)(row * fewer + n / fewer) * columns + column * fewer + n % fewer];
            print[(int64_t)row * width + column] = sum;
        }
    centre(print, (int64_t)height * width);
    for (int32_t k = 0; k < height * width; k++) power += print[k] * print[k];
    float single[9];
    for (int k = 0; k < 9; k++) single[k] = (float)warp[k];
    for (int32_t row = 0; row < tall; row++)
        for (int32_t column = 0; column < wide; column++)
            seen[(int64_t)row * wide + column] =
                block_mean(picture, single, (float)((column - reach) * fewer), (float)((row - reach) * fewer), fewer);
    centre(seen, (int64_t)tall * wide);
    float *sums = seen + (int64_t)tall * wide, *squares = sums + wide, *product = squares + wide;
    float *sum = product + side, *square = sum + side;
    for (int32_t down = 0; down < side; down++) {
        const float *from = seen + (int64_t)down * wide;
        for (int32_t k = 0; k < wide; k++) sums[k] = squares[k] = 0;
        for (int32_t k = 0; k < side; k++) product[k] = sum[k] = square[k] = 0;
        for (int32_t row = 0; row < height; row++) {
            const float *here = from + (int64_t)row * wide, *there = print + (int64_t)row * width;
            for (int32_t k = 0; k < wide; k++) {
                sums[k] += here[k];
                squares[k] += here[k] * here[k];
            }
            for (int32_t column = 0; column < width; column++)
                for (int32_t k = 0; k < side; k++) product[k] += there[column] * here[column + k];
        }
        for (int32_t column = 0; column < width; column++)
            for (int32_t k = 0; k < side; k++) {
                sum[k] += sums[column + k];
                square[k] += squares[column + k];
            }
        for (int32_t k = 0; k < side; k++) {
            const float spread = square[k] - sum[k] * sum[k] / (float)(height * width);
            /* A uniform part is no print: what rounding leaves of it must not count. */
            if (product[k] > 0 && spread > 1e-5f * square[k] && power > 0)
                total[(int64_t)down * side + k] += product[k] / __builtin_sqrtf(power * spread);
        }
    }
}
