"""Files made to harm their reader, under a film's name.  Each test names the fault that it catches."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from kit.coded_films import first_frames
from kit.crafted_films import LISTS, list_of, read_apart, readers_of, streams_of
from moireid.errors import MediaError
from moireid.verifier import video
from moireid.verifier.opened_file import OpenedFile
from moireid.verifier.video import Film

linux = pytest.mark.skipif(sys.platform != "linux", reason="memory and pipes are looked at as Linux has them")


@pytest.mark.claim("A film opens no other file")
@linux
@pytest.mark.parametrize("kind", LISTS)
def test_a_list_opens_no_other_file(tmp_path: Path, kind: str) -> None:
    """Catches: a format that is looked at after FFmpeg has read its list, and so opened the files that it names; a wait
    without an end where one of these is a pipe."""
    film, other = list_of(kind, tmp_path)
    with readers_of(other) as seen:
        with pytest.raises(MediaError, match=film.name):
            Film(film)
        assert not seen


@linux
@pytest.mark.parametrize(
    ("name", "count", "size"), [("a.mkv", 16, (7680, 4320)), ("a.mp4", 1000, (64, 64)), ("a.ts", 16, (7680, 4320))]
)
def test_too_many_streams_are_refused_before_any_is_decoded(
    tmp_path: Path, name: str, count: int, size: tuple[int, int]
) -> None:
    """Catches: pictures of each stream decoded to describe it, which took gigabytes for a film of some megabytes."""
    words, peak_mb = read_apart(streams_of(tmp_path / name, count, size))
    assert "streams" in words and str(tmp_path / name) in words and peak_mb < 400


@linux
def test_streams_that_are_not_judged_are_not_decoded(tmp_path: Path) -> None:
    """Catches: a film of few streams refused; a decoder for each of them, where only the first is read."""
    words, peak_mb = read_apart(streams_of(tmp_path / "a.mkv", video.MOST_PICTURE_STREAMS, (4096, 2304)))
    alone, alone_mb = read_apart(streams_of(tmp_path / "b.mkv", 1, (4096, 2304)))
    assert words == alone == "3 frames" and peak_mb < alone_mb + 30


def test_nothing_written_later_is_read(tmp_path: Path, films: Path) -> None:
    """Catches: a film that is written to faster than it is read, so that reading it never ends."""
    path = first_frames(films / "genuine_1.0m.mp4", tmp_path / "film.mp4", 3)
    size, opened = path.stat().st_size, OpenedFile(path)
    with path.open("ab") as grown:
        grown.write(bytes(1000))
    assert len(opened.read_at(0, 10 * size)) == size and opened.read_at(size, 10) == b""
    with pytest.raises(MediaError, match="changed"):
        opened.sha256()
