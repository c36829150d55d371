/* What the sources of the kernel share: how a picture is given, and the small algebra of homographies.
 *
 * Convention: nothing is allocated here; the caller gives the memory and has checked its size.  Pixels are read where
 *   the decoder put them: `rows` points to the first pixel of a plane of bytes whose rows are `stride` bytes apart, and
 *   `levels[256]` is the value of each byte.  A place (x, y) is counted from the middle of the first pixel, px.
 */
#ifndef MOIREID_KERNEL_H
#define MOIREID_KERNEL_H
#include <stdint.h>

/* One more with each change of a function's arguments, as in `library.py`. */
#define KERNEL_VERSION 5
#define MOST_PATCHES 16
#define BLOCK 64

#if defined(_WIN32)
#define PUBLIC __declspec(dllexport)
#else
#define PUBLIC __attribute__((visibility("default")))
#endif

/* Sums may be added up in any order: four or eight at a time. */
#define ANY_ORDER _Pragma("clang fp reassociate(on)")

typedef struct {
    const uint8_t *rows;
    const float *levels;
    int64_t stride;
    int32_t width, height;
} Picture;

/* Places of the page, counted from their middle, and a homography of them. */
typedef struct {
    const float *across, *down;
    double middle[2];
    double hull[8]; /* x and y of the corners of their bounding box */
    int32_t count;
} Places;

/* The print at sample places: `printed`, about its mean in each patch, and `power`, the sum of its squares there;
 * `free` (8, samples): change with each parameter of the warp that no gain or offset of brightness could make, and
 * `normal` (patches, 8, 8): its products in each patch.  Samples of patch k are first[k] to first[k + 1] - 1. */
typedef struct {
    Places places;
    int32_t patches, least_seen, squares;
    const int32_t *first, *side;
    const float *printed, *free;
    const double *power, *normal;
    double extent_px, least_correlation;
} Print;

/* Limits of `tracking/registration.py`, of the same names. */
typedef struct {
    int32_t max_steps, hopeless_steps, bent_seen_steps, bent_steps;
    double stop_px, left_share, min_correlation, min_gain, covered_left, covered_left_ratio;
} Rules;

typedef struct {
    double correlation, contrast, gain[MOST_PATCHES], mean[MOST_PATCHES];
    int32_t steps, seen[MOST_PATCHES];
} Comparison;

/* A homography page -> picture in single precision, of places from their middle, px from the pixel (left, top). */
typedef struct {
    float a[9];
    int32_t left, top;
} Mapping;

/* Left, top, right, bottom of the hull under a warp, px; 0 where the horizon crosses it or something is not finite. */
int bounds_of(const Places *places, const double warp[9], double bounds[4]);
Mapping mapping_of(const Places *places, const double warp[9], int32_t left, int32_t top);
/* Whether no place leaves the picture though it is worked out in single precision.  Within these limits a place is off
 * by less than 0.1 px: a numerator of `mapped` and its terms are at most MOST_SIDE times the largest depth, and an error
 * of 4e-7 of that is divided by the least depth; none of them is too large or too small for single precision. */
#define MOST_SIDE 16384
#define MOST_DEPTH 8
int is_inside(const Picture *picture, const Places *places, const double warp[9], const double bounds[4]);
/* Places first .. first + count - 1 under a mapping; count <= BLOCK. */
void mapped(const Places *places, const Mapping *mapping, int32_t first, int32_t count, float *x, float *y);

PUBLIC int32_t kernel_register(const Picture *picture, const Print *print, const Rules *rules, double *warp, float *values,
                        Comparison *found);
/* Most steps of `come_near`. */
#define COARSE_STEPS 3
int32_t come_near(const Picture *picture, const Print *print, const Rules *rules, double near_px, double warp[9],
                  float *values, Comparison *found);
PUBLIC void kernel_rows(const Picture *picture, const Places *places, const double *warp, const int32_t *counts,
                 int32_t strips, int32_t samples, float *profiles);

/* Places within the picture as the pixel at their upper left, and how far they are beyond it, in x and y. */
static inline void split(float *x, float *y, int32_t *pixel_x, int32_t *pixel_y, int32_t count) {
    for (int32_t k = 0; k < count; k++) {
        pixel_x[k] = (int32_t)x[k];
        pixel_y[k] = (int32_t)y[k];
        x[k] -= (float)pixel_x[k];
        y[k] -= (float)pixel_y[k];
    }
}

/* The four pixels around a place: the first two bytes of the upper row, then of the lower one. */
static inline uint32_t four_pixels(const uint8_t *corner, int64_t stride, int32_t x, int32_t y) {
    const uint8_t *upper = corner + y * stride + x, *lower = upper + stride;
    uint16_t above, below;
    __builtin_memcpy(&above, upper, 2);
    __builtin_memcpy(&below, lower, 2);
    return (uint32_t)above | (uint32_t)below << 16;
}
#endif
