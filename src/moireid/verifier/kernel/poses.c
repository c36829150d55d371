/* Poses of a plane by Gauss-Newton, as `camera/plane_pose.py` has them, which says what they mean. */
#include "kernel.h"

#define TERMS 10
#define PAIR(k) {1.0 / ((2 * k + 2) * (2 * k + 3)), 1.0 / ((2 * k + 3) * (2 * k + 4))}
/* Sine and cosine of a small rotation's vector, as a matrix: cos a + (1 - cos a) / a^2 v v' + sin a / a [v]x.
 * Source: Rodrigues; both quotients by their series, exact to 1e-17 up to an angle of one. */
static void rotation_of(const double v[3], double turn[9]) {
    static const double next[TERMS][2] = {PAIR(0), PAIR(1), PAIR(2), PAIR(3), PAIR(4),
                                          PAIR(5), PAIR(6), PAIR(7), PAIR(8), PAIR(9)};
    const double square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    double sine = 0, cosine = 0; /* sin a / a, (1 - cos a) / a^2 */
    for (int k = TERMS - 1; k >= 0; k--) {
        sine = 1 - square * next[k][0] * sine;
        cosine = 1 - square * next[k][1] * cosine;
    }
    cosine /= 2;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) turn[3 * i + j] = cosine * v[i] * v[j] + (i == j ? 1 - cosine * square : 0);
    turn[1] -= sine * v[2];
    turn[2] += sine * v[1];
    turn[3] += sine * v[2];
    turn[5] -= sine * v[0];
    turn[6] -= sine * v[1];
    turn[7] += sine * v[0];
}

/* Solve A x = b, A (6, 6) positive definite, in place; 0 where it is not.  Source: Cholesky; the diagonal holds one
 * over its roots, as divisions take long. */
static int solve(double a[36], double b[6]) {
    for (int i = 0; i < 6; i++)
        for (int j = 0; j <= i; j++) {
            double left = a[6 * i + j];
            for (int k = 0; k < j; k++) left -= a[6 * i + k] * a[6 * j + k];
            if (i != j) a[6 * i + j] = left * a[6 * j + j];
            else if (left > 0) a[6 * i + i] = 1 / __builtin_sqrt(left);
            else return 0;
        }
    for (int i = 0; i < 6; i++) {
        for (int k = 0; k < i; k++) b[i] -= a[6 * i + k] * b[k];
        b[i] *= a[6 * i + i];
    }
    for (int i = 5; i >= 0; i--) {
        for (int k = i + 1; k < 6; k++) b[i] -= a[6 * k + i] * b[k];
        b[i] *= a[6 * i + i];
    }
    return 1;
}

/* Normalised picture coordinates u, v of the plane's point k, and one over its depth; turned: before the shift. */
static double projected(const double *plane, int32_t k, const double r[9], const double t[3], double turned[3],
                        double *u, double *v) {
    for (int i = 0; i < 3; i++)
        turned[i] = r[3 * i] * plane[3 * k] + r[3 * i + 1] * plane[3 * k + 1] + r[3 * i + 2] * plane[3 * k + 2];
    const double near = 1 / (turned[2] + t[2]);
    *u = (turned[0] + t[0]) * near;
    *v = (turned[1] + t[1]) * near;
    return near;
}

/* Errors along the slack count less: (I - share s s') e for each of u and v.  0 where there is no slack. */
static double share_of(const double *slack, int32_t points) {
    double square = 0;
    for (int32_t k = 0; slack && k < points; k++) square += slack[k] * slack[k];
    const double kept = 1 - square > 0 ? __builtin_sqrt(1 - square) : 0;
    return (1 - kept) / (square > 1e-12 ? square : 1e-12);
}

/* Largest step, rad and share of the distance, after which a further one changes nothing that counts. */
#define SETTLED 1e-9

/* Points whose rows are kept at a time; four sums grow at once, as C adds numbers up in their order. */
#define CHUNK 16
typedef double Four __attribute__((vector_size(32)));
typedef union {
    double one[2 * CHUNK];
    Four four[CHUNK / 2];
} Row;

static double dot(const Row *a, const Row *b) {
    Four sum = a->four[0] * b->four[0];
    for (int k = 1; k < CHUNK / 2; k++) sum += a->four[k] * b->four[k];
    return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

/* Derivatives of u and v by a small rotation and by the shift, and the errors of u and v: rows of u of all points
 * before v, 0 beyond the last point. */
static void fill_rows(const double *plane, const double *seen, int32_t count, const double r[9], const double t[3],
                      Row rows[7]) {
    for (int32_t group = 0; group < CHUNK / 4; group++) {
        Four px, py, pz, su, sv, kept;
        for (int32_t l = 0; l < 4; l++) {
            const int32_t own = 4 * group + l, at = own < count ? own : 0;
            px[l] = plane[3 * at], py[l] = plane[3 * at + 1], pz[l] = plane[3 * at + 2];
            su[l] = seen[2 * at], sv[l] = seen[2 * at + 1], kept[l] = own < count;
        }
        const Four x0 = r[0] * px + r[1] * py + r[2] * pz, y0 = r[3] * px + r[4] * py + r[5] * pz;
        const Four z0 = r[6] * px + r[7] * py + r[8] * pz, near = 1 / (z0 + t[2]);
        const Four u = (x0 + t[0]) * near, v = (y0 + t[1]) * near, x = x0 * near, y = y0 * near, z = z0 * near;
        const Four of_u[7] = {-y * u, z + x * u, -y, near, 0 * near, -u * near, u - su};
        const Four of_v[7] = {-z - y * v, x * v, x, 0 * near, near, -v * near, v - sv};
        for (int i = 0; i < 7; i++) {
            rows[i].four[group] = kept * of_u[i];
            rows[i].four[CHUNK / 4 + group] = kept * of_v[i];
        }
    }
}

/* One step of Gauss-Newton; 0 where the equations have no solution, 2 where it is so short that none need follow. */
static int step_pose(const double *plane, const double *seen, const double *slack, int32_t points, double share,
                     double damping, double most_turn, double r[9], double t[3]) {
    double normal[36] = {0}, right[6] = {0}, along[2][7] = {{0}}, square = 0;
    for (int32_t begin = 0; begin < points; begin += CHUNK) {
        const int32_t count = points - begin < CHUNK ? points - begin : CHUNK;
        Row rows[7];
        fill_rows(plane + 3 * begin, seen + 2 * begin, count, r, t, rows);
        for (int i = 0; i < 6; i++) {
            for (int j = 0; j <= i; j++) normal[6 * i + j] += dot(&rows[i], &rows[j]);
            right[i] += dot(&rows[i], &rows[6]);
        }
        for (int32_t k = 0; slack && k < count; k++) {
            const double own = slack[begin + k];
            square += own * own;
            for (int side = 0; side < 2; side++)
                for (int i = 0; i < 7; i++) along[side][i] += own * rows[i].one[side * CHUNK + k];
        }
    }
    /* (I - share s s') applied to residuals and derivatives alike. */
    const double less = 2 * share - share * share * square;
    for (int side = 0; side < 2; side++)
        for (int i = 0; i < 6; i++) {
            for (int j = 0; j <= i; j++) normal[6 * i + j] -= less * along[side][i] * along[side][j];
            right[i] -= less * along[side][i] * along[side][6];
        }
    for (int i = 0; i < 6; i++) normal[7 * i] *= 1 + damping;
    if (!solve(normal, right)) return 0;
    double longest = 1e-12;
    for (int i = 0; i < 3; i++) {
        const double size = right[i] < 0 ? -right[i] : right[i];
        if (size > longest) longest = size;
    }
    const double scale = longest > most_turn ? -most_turn / longest : -1;
    double turn[9], turned[9];
    for (int i = 0; i < 6; i++) right[i] *= scale;
    rotation_of(right, turn);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            turned[3 * i + j] = turn[3 * i] * r[j] + turn[3 * i + 1] * r[3 + j] + turn[3 * i + 2] * r[6 + j];
    for (int i = 0; i < 9; i++) r[i] = turned[i];
    double moved = 0, far = 0;
    for (int i = 0; i < 3; i++) {
        t[i] += right[3 + i];
        moved += right[3 + i] * right[3 + i];
        far += t[i] * t[i];
    }
    return longest < SETTLED && moved < SETTLED * SETTLED * far ? 2 : 1;
}

/* Refine `sides` poses of each frame.  plane (points, 3); seen (frames, points, 2): normalised picture coordinates;
 * slack (frames, points), or null; rotation (frames, sides, 3, 3) and translation (frames, sides, 3): refined in place;
 * error (frames, sides): root mean square of what is left, written, negative where the plane is seen from behind or the
 * equations have no solution. */
PUBLIC void kernel_poses(const double *plane, const double *seen, const double *slack, int32_t frames, int32_t sides,
                         int32_t points, int32_t steps, double damping, double most_turn, double *rotation,
                         double *translation, double *error) {
    for (int32_t n = 0; n < frames * sides; n++) {
        const double *there = seen + (int64_t)(n / sides) * points * 2;
        const double *loose = slack ? slack + (int64_t)(n / sides) * points : 0;
        double *r = rotation + 9 * (int64_t)n, *t = translation + 3 * (int64_t)n;
        const double share = share_of(loose, points);
        double left = 0, along[2] = {0}, square = 0;
        int good = 1;
        for (int32_t step = 0; step < steps && good == 1; step++)
            good = step_pose(plane, there, loose, points, share, damping, most_turn, r, t);
        for (int32_t k = 0; k < points; k++) {
            double p[3], at[2];
            good = projected(plane, k, r, t, p, at, at + 1) > 0 ? good : 0;
            for (int side = 0; side < 2; side++) {
                const double own = at[side] - there[2 * k + side];
                left += own * own;
                along[side] += loose ? loose[k] * own : 0;
            }
            square += loose ? loose[k] * loose[k] : 0;
        }
        left -= (2 * share - share * share * square) * (along[0] * along[0] + along[1] * along[1]);
        error[n] = good && left >= 0 ? __builtin_sqrt(left / points) : -1;
        if (good && left < 0) error[n] = 0;
    }
}
