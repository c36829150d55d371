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
#define KERNEL_VERSION 3
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

/* A homography page -> picture in single precision, of places from their middle, px from the pixel (left, top). */
typedef struct {
    float a[9];
    int32_t left, top;
} Mapping;

/* Left, top, right, bottom of the hull under a warp, px; 0 where the horizon crosses it or something is not finite. */
int bounds_of(const Places *places, const double warp[9], double bounds[4]);
Mapping mapping_of(const Places *places, const double warp[9], int32_t left, int32_t top);
/* Places first .. first + count - 1 under a mapping; count <= BLOCK. */
void mapped(const Places *places, const Mapping *mapping, int32_t first, int32_t count, float *x, float *y);

/* The four pixels around a place: the first two bytes of the upper row, then of the lower one. */
static inline uint32_t four_pixels(const uint8_t *corner, int64_t stride, int32_t x, int32_t y) {
    const uint8_t *upper = corner + y * stride + x, *lower = upper + stride;
    uint16_t above, below;
    __builtin_memcpy(&above, upper, 2);
    __builtin_memcpy(&below, lower, 2);
    return (uint32_t)above | (uint32_t)below << 16;
}
#endif
