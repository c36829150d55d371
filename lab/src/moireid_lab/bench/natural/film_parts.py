"""A film's parts: where they begin, and the track of a film cut to one of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from moireid.verifier.tracking.track import Track

#: Parts of one length.
MOST_PARTS = 4


def part_starts(lengths_s: Sequence[int], film_s: float) -> dict[int, list[int]]:
    """Where the parts of each length begin in a film.

    Parameters
    ----------
    lengths_s : sequence of int
        Lengths of the parts, s; those longer than the film are left out.
    film_s : float
        Length of the film, s.

    Returns
    -------
    dict of int to list of int
        Times from the film's begin, s, by length, the longest first.

    Notes
    -----
    Convention: parts of one length do not overlap and are `MOST_PARTS` at most; each is inside a part of every longer
        length.
    """
    found: dict[int, list[int]] = {}
    longer_s, longer_starts = film_s, [0]
    for length_s in sorted((length for length in lengths_s if length <= film_s), reverse=True):
        pieces = range(int(longer_s // length_s))
        starts = [start + piece * length_s for start in longer_starts for piece in pieces]
        found[length_s] = starts[:MOST_PARTS]
        longer_s, longer_starts = length_s, found[length_s]
    return found


def cut_track(track: Track, first: int, end: int) -> Track:
    """The track of some of a film's frames, as if the film had these alone.

    Parameters
    ----------
    track : Track
        Of the whole film.
    first, end : int
        Numbers of the first frame, and of the one after the last.

    Returns
    -------
    Track
        Its times and frame numbers are those of the whole film; it has no snapshot and no times of stages.

    Notes
    -----
    Convention: uniform strips have a row for each tracked frame, rows of phase cells one for each of `cell_frames`.
    """
    frames = (track.frame_numbers >= first) & (track.frame_numbers < end)
    cells = frames[track.cell_frames]
    return replace(
        track,
        frames_read=max(min(end, track.frames_read) - max(first, 0), 0),
        frame_numbers=track.frame_numbers[frames],
        times_s=track.times_s[frames],
        homographies=track.homographies[frames],
        correlations=track.correlations[frames],
        profiles=tuple(
            profile[frames if strip.uniform else cells]
            for strip, profile in zip(track.strips, track.profiles, strict=True)
        ),
        cell_frames=(np.cumsum(frames) - 1)[track.cell_frames[cells]],
        snapshot=None,
        vague=None if track.vague is None else track.vague[frames],
        stages_s={},
    )
