"""Files made to harm their reader, under a film's name.  Each test names the fault that it catches."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from kit.coded_films import first_frames
from kit.crafted_films import LISTS, list_of, readers_of
from moireid.errors import MediaError
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


def test_nothing_written_later_is_read(tmp_path: Path, films: Path) -> None:
    """Catches: a film that is written to faster than it is read, so that reading it never ends."""
    path = first_frames(films / "genuine_1.0m.mp4", tmp_path / "film.mp4", 3)
    size, opened = path.stat().st_size, OpenedFile(path)
    with path.open("ab") as grown:
        grown.write(bytes(1000))
    assert len(opened.read_at(0, 10 * size)) == size and opened.read_at(size, 10) == b""
    with pytest.raises(MediaError, match="changed"):
        opened.sha256()
