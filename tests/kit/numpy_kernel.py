"""The kernel's equations in NumPy and OpenCV, as references: registration, brightness along strips, poses, smears."""

from __future__ import annotations

from itertools import pairwise
from types import SimpleNamespace

import cv2
import numpy as np

from moireid.verifier.camera.plane_pose import loosened, rotations
from moireid.verifier.kernel.page import PatchComparison
from moireid.verifier.tracking import registration as rules
from moireid.verifier.tracking.sampling import inverse


def mapped(warp, points):
    """Points (N, 2) under a homography."""
    x, y, w = warp @ np.column_stack([points, np.ones(len(points))]).T
    return np.column_stack([x / w, y / w])


def sampled(picture, warp, points):
    """Bilinear brightness (N,) at points under a warp; None where four pixels are not all within the picture."""
    counts = picture.whole.astype(np.float32)
    places, (height, width) = mapped(warp, points), counts.shape
    low, high = places.min(axis=0), places.max(axis=0)
    if low.min() < 0 or high[0] >= width - 1 or high[1] >= height - 1:
        return None
    left, top = low.astype(int)
    part = counts[top : int(high[1]) + 2, left : int(high[0]) + 2]
    x, y = (places - (left, top)).astype(np.float32).T
    seen = [cv2.remap(part, *one, cv2.INTER_LINEAR) for one in zip(_rows(x), _rows(y), strict=True)]
    return np.concatenate([row.ravel() for row in seen])


def _rows(values):
    """In rows, of which OpenCV takes at most 32767 values."""
    return [row[None] for row in np.array_split(values, -(-len(values) // 32767))]


def free_rows(template):
    """Change of the print with each of the warp's parameters that no gain or offset of a patch makes, (8, N)."""
    x, y = template.samples.points.T
    gx, gy = template.gradient().astype(float) * template.extent
    inward = gx * x + gy * y
    rows = np.stack([gx * x, gx * y, gx, gy * x, gy * y, gy, -inward * x, -inward * y])
    for part, printed in zip(template.samples.parts, template.printed, strict=True):
        mine = rows[:, part] - rows[:, part].mean(axis=1, keepdims=True)
        rows[:, part] = mine - np.outer(mine @ printed / float(printed @ printed), printed)
    return rows


def compared(values, template):
    """Values (N,) about each patch's mean, and the comparison with the print; without a frame's covered patches."""
    least = rules.SMEARED_CORRELATION if template.smeared else rules.MARKER_CORRELATION
    centred = [values[part] - values[part].mean() for part in template.samples.parts]
    power = [float(printed @ printed) for printed in template.printed]
    along = [float(own @ printed) for own, printed in zip(centred, template.printed, strict=True)]
    most = [np.sqrt(one * float(own @ own)) for one, own in zip(power, centred, strict=True)]
    gains = [one / two for one, two in zip(along, power, strict=True)]
    each = zip(gains, along, most, strict=True)
    seen = [gain > rules.MIN_GAIN and one >= least * two for gain, one, two in each]
    if len(seen) > rules.SQUARES and min(most) > 0:
        left = [1 - (one / two) ** 2 for one, two in zip(along, most, strict=True)]
        limit = max(rules.COVERED_LEFT, rules.COVERED_LEFT_RATIO * sorted(left)[len(left) // 2])
        seen = [shown and own <= limit for shown, own in zip(seen, left, strict=True)]
    whole = sum(two for two, shown in zip(most, seen, strict=True) if shown)
    explained = sum(one for one, shown in zip(along, seen, strict=True) if shown)
    correlation = explained / whole if whole > 0 else 0.0
    return np.concatenate(centred), PatchComparison(tuple(gains), tuple(seen), correlation, max(gains), 0)


def registered(picture, warp, template, enough):
    """The warp where `PagePrint.register` must end, with the comparison; None if the page does not match.

    Parameters: enough: whether some visible patches hold the page.
    """
    free, warp = free_rows(template), brought_near(picture, warp, template, enough)

    def step_of(centred, found, asked):
        return _step(free, template, centred, found, asked)

    def is_settled(step):
        return rules.LEFT_SHARE * np.abs(step).max() * template.extent * template.px_per_mm < rules.STOP_PX

    for steps in range(2 * rules.MAX_STEPS + 1):
        values = sampled(picture, warp, template.samples.points)
        if values is None:
            return None
        centred, found = compared(values, template)
        there = found.correlation >= rules.MIN_CORRELATION and enough(found.seen)
        if steps == 2 * rules.MAX_STEPS or (steps == rules.MAX_STEPS and not there):
            break
        if steps == rules.HOPELESS_STEPS and not any(found.seen):
            return None
        step = step_of(centred, found, found.seen if enough(found.seen) else [True] * len(found.seen))
        warp = stepped(warp, step)
        if is_settled(step):
            break
    if not all(found.seen):
        bent = warp
        for steps in range(rules.BENT_STEPS):
            values = sampled(picture, bent, template.samples.points)
            if values is None:
                break
            centred, agreed = compared(values, template)
            if steps >= rules.BENT_SEEN_STEPS and not all(agreed.seen):
                break
            step = step_of(centred, agreed, [True] * len(agreed.seen))
            if is_settled(step):
                return (bent, agreed) if all(agreed.seen) else (warp, found)
            bent = stepped(bent, step)
    return (warp, found) if enough(found.seen) and found.correlation >= rules.MIN_CORRELATION else None


def brought_near(picture, warp, template, enough):
    """The warp after some steps with a quarter of the samples.

    Unchanged where these do not settle, show too few patches, or have no use.
    """
    if template.smeared or len(template.samples.points) < rules.COARSE_FROM:
        return warp
    few, points = template.samples.every_second, template.samples.points
    every, ends = np.concatenate(few), np.cumsum([0, *map(len, few)])
    samples = SimpleNamespace(
        points=points[every],
        parts=[slice(*both) for both in pairwise(ends)],
        patch=template.samples.patch[every],
    )
    coarse = SimpleNamespace(
        samples=samples,
        printed=[template.values[part] - template.values[part].mean() for part in few],
        gradient=lambda: template.gradient()[:, every],
        extent=template.extent,
        smeared=False,
    )
    free, moved = free_rows(coarse), warp
    for _ in range(3):
        values = sampled(picture, moved, samples.points)
        if values is None:
            return warp
        centred, found = compared(values, coarse)
        step = _step(free, coarse, centred, found, found.seen if enough(found.seen) else [True] * len(found.seen))
        moved = stepped(moved, step)
        if np.abs(step).max() * template.extent * template.px_per_mm < rules.NEAR_PX:
            return moved if enough(found.seen) else warp
    return warp


def _step(free, template, centred, found, asked):
    patch = template.samples.patch
    used = np.array(asked)[patch]
    rows, gain = np.where(used, free, 0.0), np.array(found.gain)[patch]
    return np.linalg.solve(rows @ rows.T, rows @ np.where(gain > rules.MIN_GAIN, centred / gain, 0.0))


def stepped(warp, step):
    """The warp after a step of its eight parameters."""
    moved = warp @ inverse(np.append(step, 0.0).reshape(3, 3) + np.eye(3))
    return moved / moved[2, 2]


def expected_page(before, last, share):
    """As `page.expected_page`."""
    back = inverse(before)
    if back is None:
        return last
    motion = back @ last
    motion *= share / motion[2, 2]
    moved = last @ (motion + (1 - share) * np.eye(3))
    return moved / moved[2, 2]


def row_means(picture, warp, points, counts, samples):
    """Light along strips, (S, samples): nearest whole count of the bilinear coded value.

    Beyond the picture its border goes on.
    """
    height, width = picture.shape
    coded = picture.coded((0, 0, width, height)).astype(float)
    x, y = (np.clip(side, 0, most - 1) for side, most in zip(mapped(warp, points).T, (width, height), strict=True))
    column, row = (np.minimum(side.astype(int), most - 2) for side, most in ((x, width), (y, height)))
    right, down = x - column, y - row
    upper = coded[row, column] * (1 - right) + coded[row, column + 1] * right
    lower = coded[row + 1, column] * (1 - right) + coded[row + 1, column + 1] * right
    light = picture._tables[0][np.floor(upper * (1 - down) + lower * down + 0.5).astype(np.uint8)].reshape(-1, samples)
    return np.add.reduceat(light, np.cumsum([0, *counts[:-1]]), axis=0) / np.asarray(counts)[:, None]


def refined_poses(plane, seen, slack, rotation, translation, *, steps, damping, most_turn):
    """Each pose by itself, with the derivatives of each point as a matrix; as `fitting.refined_poses`."""
    rotation, translation = rotation.copy(), translation.copy()
    left = np.empty(rotation.shape[:2])
    for at in np.ndindex(left.shape):
        loose = None if slack is None else slack[at[0]]
        r, t = rotation[at], translation[at]
        for _ in range(steps):
            turned = plane @ r.T
            local = turned + t
            near = 1 / local[:, 2]
            flat = local[:, :2] * near[:, None]
            by_point = np.stack(
                [np.column_stack([near * (k == 0), near * (k == 1), -flat[:, k] * near]) for k in (0, 1)]
            )
            jacobian = np.concatenate([np.cross(turned[None], by_point), by_point], axis=-1)
            errors = (flat - seen[at[0]]).T
            if loose is not None:
                jacobian = np.moveaxis(loosened(np.moveaxis(jacobian, 1, 2), loose), 2, 1)
                errors = loosened(errors, loose)
            rows = jacobian.reshape(-1, 6)
            normal = rows.T @ rows
            step = -np.linalg.solve(normal + damping * np.diag(np.diag(normal)), rows.T @ errors.ravel())
            step *= min(1.0, most_turn / np.abs(step[:3]).max())
            r, t = rotations(step[:3]) @ r, t + step[3:]
        local = plane @ r.T + t
        errors = (local[:, :2] / local[:, 2:] - seen[at[0]]).T
        errors = errors if loose is None else loosened(errors, loose)
        rotation[at], translation[at] = r, t
        left[at] = np.sqrt((errors**2).sum(axis=0).mean()) if local[:, 2].min() > 0 else np.inf
    return rotation, translation, left


def smeared_means(phases, corner, shape, motion, steps):
    """By OpenCV's remap, one step after another; as `fitting.smeared_means`."""
    whole = phases.transpose(2, 0, 3, 1).reshape(2 * phases.shape[2], 2 * phases.shape[3])
    down, across = np.meshgrid(np.arange(shape[0]), np.arange(shape[1]), indexing="ij")
    most = [2 * (size - part) - 2 for size, part in zip(phases.shape[2:], shape, strict=True)]
    seen = []
    for share in (np.arange(steps) + 0.5) / steps - 0.5:
        first = np.clip([2 * start - 2 * way * share for start, way in zip(corner, motion[::-1], strict=True)], 0, most)
        y, x = (np.float32(2 * part + start) for part, start in zip((down, across), first, strict=True))
        seen.append(cv2.remap(whole, x, y, cv2.INTER_LINEAR))
    return np.mean(seen, axis=0).ravel()


def block_means(values, fewer):
    """Means of whole blocks of `fewer` x `fewer` values."""
    rows, columns = (size // fewer for size in values.shape)
    return values[: rows * fewer, : columns * fewer].reshape(rows, fewer, columns, fewer).mean(axis=(1, 3))


def correlations(picture, warp, printed, fewer, reach):
    """As `page.correlations`, by OpenCV's."""
    printed = block_means(printed, fewer)
    rows, columns = (size + 2 * reach for size in printed.shape)
    at = (fewer - 1) / 2 + (np.array([-0.25, 0.25]) * fewer if fewer > 1 else np.zeros(2))
    y, x = ((np.arange(size)[:, None] - reach) * fewer + at for size in (rows, columns))
    grid = np.meshgrid(x.ravel(), y.ravel())
    places = mapped(warp, np.column_stack([part.ravel() for part in grid])).reshape(2 * rows, 2 * columns, 2)
    height, width = picture.shape
    places = np.clip(places, 0, (width - 2, height - 2)).astype(np.float32)
    flat = block_means(cv2.remap(picture.whole.astype(np.float32), places, None, cv2.INTER_LINEAR), 2)
    found = cv2.matchTemplate(flat.astype(np.float32), printed.astype(np.float32), cv2.TM_CCOEFF_NORMED)
    return np.maximum(found, 0)


#: Directions in which a component's extreme points are kept, around the clock.
WAYS = np.array([(-1, -1), (0, -1), (1, -1), (1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0)])


def dark_pixels(coded, window, steps):
    """Which pixels (height, width) are below the mean of the window around them by more than `steps`."""
    half = window // 2
    sums = cv2.boxFilter(np.pad(coded, half, mode="edge").astype(np.float64), -1, (window, window), normalize=False)[
        half : half + coded.shape[0], half : half + coded.shape[1]
    ]
    return np.rint(sums) > window**2 * (coded.astype(float) + steps)


def _area(points):
    x, y = points.T.astype(float)
    return float(x @ np.roll(y, -1) - np.roll(x, -1) @ y) / 2


def _quadrangle(rows, columns, least_px):
    """Corners (4, 2) of a component, from its pixels; None if it is no quadrangle or too small."""
    if np.ptp(rows) + np.ptp(columns) + 2 < 2 * least_px:
        return None
    ends = []
    for across, down in WAYS:
        far = across * columns + down * rows
        at = np.flatnonzero(far == far.max())
        # The first row that is as far; where a whole run is, its middle.
        at = at[rows[at] == rows[at].min()]
        if across == 0:
            row = np.sort(columns[at])
            first = row[: int(np.argmax(np.diff(row, append=row[-1] + 2) > 1)) + 1]
            ends.append(((first[0] + first[-1]) // 2, rows[at[0]]))
        else:
            ends.append((columns[at[0]], rows[at[0]]))
    ends = np.array(ends)
    slanted, upright = ends[0::2], ends[1::2]
    quad = slanted if _area(slanted) >= _area(upright) else upright
    sides = np.linalg.norm(quad - np.roll(quad, -1, axis=0), axis=1)
    perimeter = float(sides.sum())
    if _area(quad) < 0.8 * _area(ends) or perimeter + 4 < 4 * least_px or sides.min() < perimeter / 16:
        return None
    return quad.astype(float)


def _word(coded, quad, codes, steps):
    """The number of the word that a quadrangle shows; None for none."""
    side = codes.cells + 2
    # The closed form of the kernel keeps a horizon away; so does this.
    if abs(_area(quad[[1, 2, 3]]) * 2) <= 0.5:
        return None
    unit = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], np.float32)
    warp = cv2.getPerspectiveTransform(unit, quad.astype(np.float32))
    if min(warp[2] @ (1, 0, 1), warp[2] @ (0, 1, 1), warp[2] @ (1, 1, 1)) <= 0.1:
        return None
    column, row, k = np.meshgrid(np.arange(side), np.arange(side), np.arange(4))
    places = np.stack([column + 0.4 + 0.2 * (k % 2), row + 0.4 + 0.2 * (k // 2)], axis=-1).reshape(-1, 2) / side
    at = mapped(warp, places).astype(np.float32).reshape(-1, 1, 2)
    values = cv2.remap(coded.astype(np.float32), at, None, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    seen = values.reshape(side, side, 4).mean(axis=2)
    code = seen[1:-1, 1:-1]
    border = np.delete(seen.ravel(), np.arange(side**2).reshape(side, side)[1:-1, 1:-1].ravel())
    middle = (border.mean() + code.max()) / 2
    if code.max() < border.mean() + steps or (border > middle).sum() > codes.most_wrong_border:
        return None
    word = sum(1 << place for place in np.flatnonzero(code > middle).tolist())
    wrong = [(word ^ int(one)).bit_count() for one in codes.words.ravel()]
    return int(np.argmin(wrong)) if min(wrong) <= codes.most_wrong else None


def squares(coded, codes, *, window, steps, least_px):
    """Squares that show a word, as {word: corners}, the runs of dark pixels, and the quadrangles that were read."""
    dark = dark_pixels(coded, window, steps)
    runs = int((np.diff(dark.astype(int), axis=1, prepend=0) > 0).sum())
    count, labels = cv2.connectedComponents(dark.astype(np.uint8), connectivity=8)
    found, read = [], 0
    for label in range(1, count):
        quad = _quadrangle(*np.nonzero(labels == label), least_px)
        if quad is None:
            continue
        read += 1
        word = _word(coded, quad, codes, steps)
        if word is not None:
            perimeter = np.linalg.norm(quad - np.roll(quad, -1, axis=0), axis=1).sum()
            found.append((word, quad + (quad - quad.mean(axis=0)) * 4 / perimeter))
    return found, runs, read
