/* Finding square markers in a picture: one threshold, its dark components row by row, and their bits.
 *
 * Source: a pixel is dark if it is below the mean of a square window around it by so much, as in OpenCV's search;
 *   components of eight neighbours, by runs of dark pixels and union-find over two rows (Rosenfeld and Pfaltz, 1966).
 *   Of a component only its extreme points in eight directions are kept.  Of a square those in four directions that are
 *   a right angle apart are its corners: where it is upright the slanted ones, else the others.
 */
#include "kernel.h"

/* window: of the threshold, odd, up to 15 px; steps: by which a dark pixel is below its mean, up to 30; cells: of a
 * marker's code, across and down, 1 to 8, without its dark border of one cell; words (classes, 4): codes, row by row,
 * the first cell in the lowest bit, each by quarter turns; most_wrong: cells of the code that may be wrong;
 * most_wrong_border: cells of the border that may be bright; least_px: mean side of a square. */
typedef struct {
    int32_t window, steps, cells, classes, most_wrong, most_wrong_border;
    double least_px;
    const uint64_t *words;
} SquareRules;

/* Corners, clockwise from the one that is up left in the picture; perimeter: of the middles of its
 * outer pixels; word: which one was read. */
typedef struct {
    double corners[8], perimeter;
    int32_t word, unused;
} Square;

#define DIRECTIONS 8
/* Around the clock, so that the extreme points of a component are a polygon. */
static const int32_t WAYS[DIRECTIONS][2] = {{-1, -1}, {0, -1}, {1, -1}, {1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}};

/* Most extreme points: how far in each direction, and where. */
typedef struct {
    int32_t far[DIRECTIONS], x[DIRECTIONS], y[DIRECTIONS];
    int32_t parent, last; /* parent: itself, the component that it was joined to, or -1; last: its last row */
} Component;

typedef struct {
    int32_t begin, end, component;
} Run;

/* A component's quadrangle must fill this share of its extreme points' polygon; one of round things fills 0.7. */
#define LEAST_FILL 0.8

static void extend(Component *component, int32_t direction, int32_t x, int32_t y) {
    const int32_t far = WAYS[direction][0] * x + WAYS[direction][1] * y;
    if (far <= component->far[direction]) return;
    component->far[direction] = far;
    component->x[direction] = x;
    component->y[direction] = y;
}

/* Its ends are all that can be extreme in a row. */
static void take_run(Component *component, int32_t begin, int32_t end, int32_t y) {
    extend(component, 0, begin, y);
    extend(component, 7, begin, y);
    extend(component, 6, begin, y);
    extend(component, 2, end - 1, y);
    extend(component, 3, end - 1, y);
    extend(component, 4, end - 1, y);
    extend(component, 1, (begin + end - 1) / 2, y);
    extend(component, 5, (begin + end - 1) / 2, y);
}

static int32_t root_of(Component *components, int32_t at) {
    while (components[at].parent != at) {
        components[at].parent = components[components[at].parent].parent;
        at = components[at].parent;
    }
    return at;
}

static int32_t joined(Component *components, int32_t one, int32_t other) {
    if (one == other) return one;
    for (int32_t k = 0; k < DIRECTIONS; k++)
        extend(&components[one], k, components[other].x[k], components[other].y[k]);
    components[other].parent = one;
    return one;
}

static double area_of(const Component *component, int32_t first, int32_t step) {
    double twice = 0;
    for (int32_t k = first; k < DIRECTIONS; k += step) {
        const int32_t next = (k + step) % DIRECTIONS;
        twice += (double)component->x[k] * component->y[next] - (double)component->x[next] * component->y[k];
    }
    return twice / 2;
}

static double distance(const double *one, const double *other) {
    const double x = one[0] - other[0], y = one[1] - other[1];
    return __builtin_sqrt(x * x + y * y);
}

/* Corners of the component if it is a quadrangle that is large enough. */
static int quadrangle(const Component *component, double least_px, Square *square) {
    /* Cheap for what is small, as noise is. */
    if (component->far[3] + component->far[7] + component->far[5] + component->far[1] + 2 < 2 * least_px) return 0;
    const double slanted = area_of(component, 0, 2), upright = area_of(component, 1, 2);
    const int32_t first = slanted >= upright ? 0 : 1;
    if ((first ? upright : slanted) < LEAST_FILL * area_of(component, 0, 1)) return 0;
    for (int32_t k = 0; k < 4; k++) {
        square->corners[2 * k] = component->x[first + 2 * k];
        square->corners[2 * k + 1] = component->y[first + 2 * k];
    }
    double perimeter = 0, shortest = 1e9;
    for (int32_t k = 0; k < 4; k++) {
        const double side = distance(&square->corners[2 * k], &square->corners[2 * ((k + 1) % 4)]);
        perimeter += side;
        shortest = side < shortest ? side : shortest;
    }
    if (perimeter + 4 < 4 * least_px || shortest < perimeter / 16) return 0;
    square->perimeter = perimeter;
    return 1;
}

/* Homography from the unit square to a quadrangle; 0 where there is none.
 * Source: Heckbert, Fundamentals of Texture Mapping and Image Warping, 1989. */
static int square_to(const double c[8], double warp[9]) {
    const double sx = c[0] - c[2] + c[4] - c[6], sy = c[1] - c[3] + c[5] - c[7];
    const double ax = c[2] - c[4], ay = c[3] - c[5], bx = c[6] - c[4], by = c[7] - c[5];
    const double across = ax * by - bx * ay;
    if (!(across > 0.5 || across < -0.5)) return 0;
    const double g = (sx * by - bx * sy) / across, h = (ax * sy - sx * ay) / across;
    const double found[9] = {c[2] - c[0] + g * c[2], c[6] - c[0] + h * c[6], c[0],
                             c[3] - c[1] + g * c[3], c[7] - c[1] + h * c[7], c[1], g, h, 1};
    for (int32_t k = 0; k < 9; k++) warp[k] = found[k];
    return 1 + g > 0.1 && 1 + h > 0.1 && 1 + g + h > 0.1;
}

/* Brightness at a place of the unit square, between the four pixels around it, in the picture's own steps. */
static double value_at(const Picture *picture, const double warp[9], double u, double v) {
    const double w = warp[6] * u + warp[7] * v + 1, most_x = picture->width - 1, most_y = picture->height - 1;
    double x = (warp[0] * u + warp[1] * v + warp[2]) / w, y = (warp[3] * u + warp[4] * v + warp[5]) / w;
    x = x > 0 ? x : 0;
    y = y > 0 ? y : 0;
    x = x < most_x ? x : most_x;
    y = y < most_y ? y : most_y;
    const int32_t column = (int32_t)x < picture->width - 2 ? (int32_t)x : picture->width - 2;
    const int32_t row = (int32_t)y < picture->height - 2 ? (int32_t)y : picture->height - 2;
    const uint32_t four = four_pixels(picture->rows, picture->stride, column, row);
    const double right = x - column, down = y - row;
    const double a = four & 255, b = four >> 8 & 255, c = four >> 16 & 255, d = four >> 24;
    return a + right * (b - a) + down * (c + right * (d - c) - a - right * (b - a));
}

/* The word that a quadrangle shows, the one with fewest wrong cells; -1 for none. */
static int32_t word_of(const Picture *picture, const SquareRules *rules, const double corners[8]) {
    double warp[9], seen[100], border = 0, brightest = 0;
    const int32_t side = rules->cells + 2;
    if (!square_to(corners, warp)) return -1;
    for (int32_t row = 0; row < side; row++) {
        for (int32_t column = 0; column < side; column++) {
            /* Near the middle, as the cells of small squares are blurred. */
            double sum = 0;
            for (int32_t k = 0; k < 4; k++) {
                const double across = column + 0.4 + 0.2 * (k % 2), down = row + 0.4 + 0.2 * (k / 2);
                sum += value_at(picture, warp, across / side, down / side);
            }
            seen[side * row + column] = sum / 4;
            const int outer = row == 0 || column == 0 || row == side - 1 || column == side - 1;
            border += outer ? sum / 4 : 0;
            if (!outer && sum / 4 > brightest) brightest = sum / 4;
        }
    }
    border /= 4 * (side - 1);
    if (brightest < border + rules->steps) return -1;
    const double middle = (border + brightest) / 2;
    int32_t wrong_border = 0, best = -1, fewest = rules->most_wrong + 1;
    uint64_t word = 0;
    for (int32_t row = 0; row < side; row++) {
        for (int32_t column = 0; column < side; column++) {
            const int bright = seen[side * row + column] > middle;
            const int outer = row == 0 || column == 0 || row == side - 1 || column == side - 1;
            if (outer) wrong_border += bright;
            else word |= (uint64_t)bright << (rules->cells * (row - 1) + column - 1);
        }
    }
    if (wrong_border > rules->most_wrong_border) return -1;
    for (int32_t k = 0; k < 4 * rules->classes; k++) {
        const int32_t wrong = __builtin_popcountll(word ^ rules->words[k]);
        if (wrong < fewest) {
            fewest = wrong;
            best = k;
        }
    }
    return best;
}

/* Moves corners from the middles of a square's outer pixels to its outer edges. */
static void widen(Square *square) {
    double middle[2] = {0, 0};
    for (int32_t k = 0; k < 8; k++) middle[k % 2] += square->corners[k] / 4;
    for (int32_t k = 0; k < 8; k++) square->corners[k] += (square->corners[k] - middle[k % 2]) * 4 / square->perimeter;
}

/* Keeps the largest `most` squares of each class. */
static void keep(const Square *square, Square *found, int32_t *counts, int32_t most) {
    const int32_t class = square->word / 4;
    Square *own = found + (int64_t)class * most;
    if (counts[class] < most) {
        own[counts[class]++] = *square;
        return;
    }
    Square *least = own;
    for (int32_t k = 1; k < most; k++) least = own[k].perimeter < least->perimeter ? &own[k] : least;
    if (square->perimeter > least->perimeter) *least = *square;
}

/* Runs of dark pixels in a row; dark (width + 8,): 1 where a pixel is dark, 0 also beyond the width. */
static int32_t runs_of(const uint8_t *dark, int32_t width, Run *runs) {
    int32_t changed = 0;
    uint64_t before = 0;
    for (int32_t first = 0; first <= width; first += 8) {
        uint64_t eight;
        /* The first pixel is the lowest byte on all platforms that the kernel is built for. */
        __builtin_memcpy(&eight, dark + first, 8);
        uint64_t changes = eight ^ (eight << 8 | before);
        before = eight >> 56;
        for (; changes; changes &= changes - 1, changed++) {
            const int32_t at = first + __builtin_ctzll(changes) / 8;
            if (changed % 2) runs[changed / 2].end = at;
            else runs[changed / 2].begin = at;
        }
    }
    return changed / 2;
}

/* What is kept of a row and the one above, within the memory that the caller gives. */
typedef struct {
    uint16_t *columns;
    uint8_t *dark;
    Run *runs, *above;
    Component *components;
    int32_t *unused;
} Room;

/* Columns before and after the picture are read in blocks. */
#define PADDED(width) ((int64_t)(width) + BLOCK + 48)

/* A row has at most one run for two pixels, and each of it and the row above a component. */
static int64_t room_within(uint8_t *memory, int32_t width, Room *room) {
    const int64_t runs = width / 2 + 1, padded = PADDED(width);
    uint8_t *at = memory;
#define TAKE(field, count) room->field = (void *)at, at += ((count) * (int64_t)sizeof(*room->field) + 15) / 16 * 16
    TAKE(columns, padded);
    TAKE(dark, padded);
    TAKE(runs, runs);
    TAKE(above, runs);
    TAKE(components, 2 * runs);
    TAKE(unused, 2 * runs);
#undef TAKE
    return at - memory;
}

/* Bytes of memory that `kernel_squares` needs for pictures of a width, a multiple of 16 from its start. */
PUBLIC int64_t kernel_squares_room(int32_t width) {
    Room room;
    return room_within((uint8_t *)64, width, &room);
}

/* A row of the picture that its first or last row goes on for beyond it. */
static const uint8_t *row_at(const Picture *picture, int32_t y) {
    y = y < 0 ? 0 : y < picture->height ? y : picture->height - 1;
    return picture->rows + y * picture->stride;
}

/* Adds a row to sums of columns and takes away another one. */
static void roll(uint16_t *restrict columns, const uint8_t *restrict in, const uint8_t *restrict out, int32_t width) {
    for (int32_t x = 0; x < width; x++) columns[x] = (uint16_t)(columns[x] + in[x] - out[x]);
}

/* Which of BLOCK pixels are dark.  columns (BLOCK + 32,): of the picture's column sums, the first half a window before
 * the first pixel.  Sums of 1, 2, 4 and 8 columns make up the window's. */
static void darkened(const SquareRules *rules, const uint16_t *restrict columns, const uint8_t *restrict row,
                     uint8_t *restrict dark) {
    uint16_t two[BLOCK + 24], four[BLOCK + 16], sums[BLOCK];
    const int32_t window = rules->window;
    const uint16_t area = (uint16_t)(window * window), steps = (uint16_t)rules->steps;
    for (int32_t k = 0; k < BLOCK + 24; k++) two[k] = (uint16_t)(columns[k] + columns[k + 1]);
    for (int32_t k = 0; k < BLOCK + 16; k++) four[k] = (uint16_t)(two[k] + two[k + 2]);
    for (int32_t k = 0; k < BLOCK; k++) sums[k] = columns[k]; /* a window is odd */
    if (window & 2)
        for (int32_t k = 0; k < BLOCK; k++) sums[k] = (uint16_t)(sums[k] + two[k + 1]);
    if (window & 4)
        for (int32_t k = 0; k < BLOCK; k++) sums[k] = (uint16_t)(sums[k] + four[k + (window & 3)]);
    if (window & 8)
        for (int32_t k = 0, at = window & 7; k < BLOCK; k++)
            sums[k] = (uint16_t)(sums[k] + four[k + at] + four[k + at + 4]);
    for (int32_t k = 0; k < BLOCK; k++) two[k] = (uint16_t)(area * (uint16_t)(row[k] + steps));
    for (int32_t k = 0; k < BLOCK; k++) two[k] = sums[k] > two[k] ? 1 : 0;
    for (int32_t k = 0; k < BLOCK; k++) dark[k] = (uint8_t)two[k];
}

/* Which pixels of a row are dark; beyond the picture its border goes on. */
static void threshold(const Picture *picture, const SquareRules *rules, const Room *room, int32_t y) {
    const int32_t width = picture->width, half = rules->window / 2;
    /* Of columns before the picture and after it, which the window reaches into, the border's are taken. */
    uint16_t *columns = room->columns + 8;
    if (y == 0) {
        for (int32_t x = 0; x < width; x++) columns[x] = 0;
        for (int32_t k = -half; k <= half; k++)
            for (int32_t x = 0; x < width; x++) columns[x] = (uint16_t)(columns[x] + row_at(picture, k)[x]);
    } else {
        roll(columns, row_at(picture, y + half), row_at(picture, y - half - 1), width);
    }
    for (int32_t x = -8; x < 0; x++) columns[x] = columns[0];
    for (int32_t x = width; x < width + 8; x++) columns[x] = columns[width - 1];
    const uint8_t *row = row_at(picture, y);
    int32_t x = 0;
    for (; x + BLOCK <= width; x += BLOCK) darkened(rules, columns + x - half, row + x, room->dark + x);
    uint8_t last[BLOCK] = {0}, dark[BLOCK];
    for (int32_t k = 0; k < width - x; k++) last[k] = row[x + k];
    darkened(rules, columns + x - half, last, dark);
    for (int32_t k = 0; k < width - x; k++) room->dark[x + k] = dark[k];
}

/* The squares of a picture that show one of the words: found (classes, most), counts (classes,) of them.
 * work: runs of dark pixels, and quadrangles that were read.  memory: `kernel_squares_room` bytes, a multiple of 16. */
PUBLIC void kernel_squares(const Picture *picture, const SquareRules *rules, uint8_t *memory, Square *found,
                           int32_t *counts, int32_t most, int64_t work[2]) {
    Room room;
    room_within(memory, picture->width, &room);
    const int32_t width = picture->width;
    int32_t above = 0, unused = 2 * (width / 2 + 1);
    for (int32_t k = 0; k < unused; k++) room.unused[k] = k;
    for (int64_t k = 0; k < PADDED(width); k++) {
        room.columns[k] = 0;
        room.dark[k] = 0;
    }
    for (int32_t k = 0; k < rules->classes; k++) counts[k] = 0;
    work[0] = work[1] = 0;
    Component *components = room.components;
    /* A row without a run comes last, so that all components end. */
    for (int32_t y = 0; y <= picture->height; y++) {
        int32_t count = 0, first = 0;
        if (y < picture->height) {
            threshold(picture, rules, &room, y);
            count = runs_of(room.dark, width, room.runs);
        }
        work[0] += count;
        for (int32_t k = 0; k < count; k++) {
            Run *run = &room.runs[k];
            while (first < above && room.above[first].end < run->begin) first++;
            int32_t own = -1;
            for (int32_t n = first; n < above && room.above[n].begin <= run->end; n++) {
                const int32_t other = root_of(components, room.above[n].component);
                own = own < 0 ? other : joined(components, own, other);
            }
            if (own < 0) {
                own = room.unused[--unused];
                for (int32_t d = 0; d < DIRECTIONS; d++) components[own].far[d] = INT32_MIN;
                components[own].parent = own;
            }
            take_run(&components[own], run->begin, run->end, y);
            run->component = own;
        }
        for (int32_t k = 0; k < count; k++) {
            room.runs[k].component = root_of(components, room.runs[k].component);
            components[room.runs[k].component].last = y;
        }
        for (int32_t k = 0; k < above; k++) {
            const int32_t own = room.above[k].component;
            Component *component = &components[own];
            if (component->parent < 0 || (component->parent == own && component->last == y)) continue;
            Square square = {{0}, 0, -1, 0};
            if (component->parent == own && quadrangle(component, rules->least_px, &square)) {
                work[1]++;
                square.word = word_of(picture, rules, square.corners);
                if (square.word >= 0) {
                    widen(&square);
                    keep(&square, found, counts, most);
                }
            }
            component->parent = -1;
            room.unused[unused++] = own;
        }
        Run *swap = room.above;
        room.above = room.runs;
        room.runs = swap;
        above = count;
    }
}
