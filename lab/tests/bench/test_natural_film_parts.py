"""A film's parts, and a track cut to one.  Each test names what it would catch."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from moireid.verifier.tracking.track import Track
from moireid_lab.bench.natural import LENGTHS_S, MOST_PARTS, cut_track, part_starts

#: Tracked frames by their numbers: the badge is not found in frames 3 and 4.
NUMBERS = np.array([0, 1, 2, 5, 6, 7, 8, 9])
#: Rows of the track in which the phase cells were read.
CELL_ROWS = np.array([0, 2, 3, 6])


@pytest.fixture
def track() -> Track:
    """A track whose values are its frames' numbers."""
    strips: Any = (SimpleNamespace(uniform=True), SimpleNamespace(uniform=False))
    profiles = (np.repeat(NUMBERS[:, None], 3, 1), np.repeat(NUMBERS[CELL_ROWS, None], 2, 1))
    return Track(
        badge=SimpleNamespace(),  # type: ignore[arg-type]
        frames_read=10,
        frame_numbers=NUMBERS,
        times_s=NUMBERS / 30,
        homographies=NUMBERS[:, None, None] * np.ones((3, 3)),
        correlations=NUMBERS / 10,
        profiles=tuple(profile.astype(np.float32) for profile in profiles),
        cell_frames=CELL_ROWS,
        strips=strips,
        image_px=(640, 480),
        snapshot=np.zeros((2, 2), np.uint8),
        stages_s={"find": 1.0},
    )


def test_a_cut_track_keeps_the_rows_of_its_frames(track):
    """Catches: rows counted where frames are meant; rows of phase cells cut as those of uniform strips."""
    part = cut_track(track, 2, 9)
    numbers = [2, 5, 6, 7, 8]
    assert part.frames_read == 7 and part.tracked == 5
    assert part.frame_numbers.tolist() == numbers and part.times_s == pytest.approx(np.array(numbers) / 30)
    assert part.homographies[:, 0, 0].tolist() == numbers and part.correlations == pytest.approx(np.array(numbers) / 10)
    even, cells = part.profiles
    assert even[:, 0].tolist() == numbers and cells[:, 0].tolist() == [2, 5, 8]
    assert part.frame_numbers[part.cell_frames].tolist() == [2, 5, 8]
    assert part.snapshot is None and part.stages_s == {} and part.vague is None


def test_what_is_vague_is_cut_too(track):
    """Catches: the error ratios of other frames."""
    vague = np.repeat(NUMBERS[:, None], 2, 1).astype(float)
    assert cut_track(replace(track, vague=vague), 5, 8).vague[:, 1].tolist() == [5, 6, 7]


def test_a_cut_at_the_whole_film_changes_no_row(track):
    """Catches: the last frame lost; more frames read than there are."""
    whole = cut_track(track, 0, 99)
    assert whole.frames_read == 10 and np.array_equal(whole.cell_frames, track.cell_frames)
    assert all(np.array_equal(one, other) for one, other in zip(whole.profiles, track.profiles, strict=True))


def test_no_part_overlaps_another_of_its_length_and_all_are_inside_longer_ones():
    """Catches: parts that reach over a longer one's end, so that pairs are lost; a fifth part."""
    starts = part_starts(LENGTHS_S, 40.0)
    assert starts == {40: [0], 20: [0, 20], 10: [0, 10, 20, 30], 7: [0, 10, 20, 30], 4: [0, 10, 20, 30]}
    lengths = list(starts)
    for longer, length in pairwise(lengths):
        assert len(starts[length]) <= MOST_PARTS and np.all(np.diff(starts[length]) >= length)
        assert all(any(a <= b and b + length <= a + longer for a in starts[longer]) for b in starts[length])
    assert part_starts((4, 7, 40), 13.0) == {7: [0], 4: [0]} and part_starts((40,), 39.9) == {}
