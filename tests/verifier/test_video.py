"""Films as files: the luma that comes out of them, whatever they are coded in."""

from __future__ import annotations

import hashlib
import re
import struct
import subprocess
import sys
import threading
import zlib
from fractions import Fraction
from itertools import islice
from pathlib import Path

import av
import numpy as np
import pytest

from kit.coded_films import written
from moireid.errors import MediaError
from moireid.verifier import Question, verify, video
from moireid.verifier.picture import LINEAR_COUNTS
from moireid.verifier.video import Film, picture_of


@pytest.mark.parametrize(
    ("codec", "pixels", "full_range"),
    [
        ("libx264", "yuv420p", False),
        ("libx264", "yuvj420p", True),
        ("libx264", "yuv444p", False),
        ("libx265", "yuv420p10le", False),
        ("libx265", "yuv420p", False),
    ],
)
def test_brightness_comes_out_as_it_went_in(codec, pixels, full_range, tmp_path):
    """Catches: a range stretched twice or not at all, ten bits cut at the wrong end, padding taken for picture."""
    # A width that no decoder's row length equals.
    ramp = np.tile(np.linspace(0, 255, 182).astype(np.uint8), (96, 1))
    film = Film(written(tmp_path / "ramp.mp4", [ramp, ramp[:, ::-1]], codec, pixels, full_range=full_range))
    seen = [frame.luma for frame in film.frames()]
    assert [luma.shape for luma in seen] == [(96, 182)] * 2 and seen[0].dtype == np.uint8
    for picture, wanted in zip(seen, (ramp, ramp[:, ::-1]), strict=True):
        # The encoder of H.265 spoils eight pixels of a row now and then, by any decoder.
        assert np.mean(np.abs(picture.astype(int) - wanted) > 3) < 0.005


def test_the_luma_plane_is_what_a_conversion_would_give(films: Path):
    """Catches: a look-up table that is a count off, rows that slip by the decoder's padding."""
    with av.open(str(films / "genuine_2.0m.mp4")) as container:
        for _, picture in zip(range(3), container.decode(video=0), strict=False):
            assert np.array_equal(picture_of(picture).whole, picture.to_ndarray(format="gray"))


def test_a_frame_that_is_kept_stays_as_it_was(films: Path):
    """Catches: brightness read from memory that the decoder has given to a later frame by then."""
    film = Film(films / "genuine_2.0m.mp4")
    kept = list(islice(film.frames(), 90))
    for frame, now in zip(kept, film.frames(), strict=False):
        assert np.array_equal(frame.luma, now.luma.copy())


def test_a_part_is_that_of_the_whole(films: Path):
    """Catches: a part cut with rows and columns exchanged, or left in coded counts; a mirror that shifts the middle."""
    picture = next(Film(films / "genuine_2.0m.mp4").frames()).picture
    whole = picture.whole
    assert np.array_equal(picture.part((300, 200, 420, 250)), whole[200:250, 300:420])
    assert np.array_equal(picture.mirrored().whole, whole[:, ::-1])
    assert np.array_equal(picture.in_light.part((300, 200, 420, 250)), LINEAR_COUNTS[whole[200:250, 300:420]])


def decoders() -> list[threading.Thread]:
    return [thread for thread in threading.enumerate() if thread.name.startswith("decode")]


@pytest.mark.parametrize(
    ("aspect", "size"),
    [(Fraction(4, 3), (256, 96)), (Fraction(3, 4), (192, 128)), (Fraction(1), (192, 96)), (Fraction(9, 1), (192, 96))],
)
def test_pixels_that_are_not_square_are_made_so(tmp_path, aspect, size):
    """Catches: a flag that is not obeyed, which makes a wrong parallax; an absurd one that is; a picture shrunk."""
    picture = np.zeros((96, 192), np.uint8)
    picture[24:48, 48:96] = 200
    film = Film(written(tmp_path / "wide.mp4", [picture] * 4, "libx264", "yuv420p", aspect=aspect))
    assert (film.width, film.height) == size == (film.described()["width"], film.described()["height"])
    luma = next(iter(film.frames())).luma
    assert luma.shape == size[::-1]
    rows, columns = np.nonzero(luma > 100)
    across, down = size[0] / 192, size[1] / 96
    assert np.allclose([columns.min(), columns.max() + 1], [48 * across, 96 * across], atol=1)
    assert np.allclose([rows.min(), rows.max() + 1], [24 * down, 48 * down], atol=1)


@pytest.mark.parametrize("error", [None, ValueError("raised by the test"), KeyboardInterrupt()])
def test_the_decoder_ends_with_its_reader(films: Path, error):
    """Catches: a thread that waits for ever behind a reader who left early, broke down or was interrupted."""
    frames = Film(films / "genuine_2.0m.mp4").frames_ahead()
    next(frames)
    assert decoders()
    if error is None:
        frames.close()
    else:
        with pytest.raises(type(error)):
            frames.throw(error)
    assert not decoders()


@pytest.mark.parametrize("good", [0, 2, 4, 5])
def test_an_error_of_the_decoder_comes_at_its_frame(tmp_path, monkeypatch, good):
    """Catches: an error that is lost in the thread, or raised before the frames ahead of it were given out."""
    film = Film(written(tmp_path / "a.mp4", [np.zeros((64, 64), np.uint8)] * 8, "libx264", "yuv420p"))
    made = []

    def breaking(picture):
        if len(made) == good:
            raise MediaError("another picture size")
        made.append(1)
        return picture_of(picture)

    monkeypatch.setattr(video, "picture_of", breaking)
    seen = []
    with pytest.raises(MediaError, match="picture size"):
        seen.extend(frame.index for frame in film.frames_ahead())
    assert seen == list(range(good)) and not decoders()


def huge_png(width: int, height: int) -> bytes:
    """A film of one picture as an animated PNG, of a few bytes, with any size in its header."""

    def chunk(tag: bytes, body: bytes) -> bytes:
        return struct.pack(">I", len(body)) + tag + body + struct.pack(">I", zlib.crc32(tag + body))

    control = chunk(b"acTL", struct.pack(">II", 1, 0)) + chunk(
        b"fcTL", struct.pack(">IIIIIHHBB", 0, width, height, 0, 0, 1, 30, 0, 0)
    )
    head = chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 6, 0, 0, 0))
    return b"\x89PNG\r\n\x1a\n" + head + control + chunk(b"IDAT", zlib.compress(bytes(4000))) + chunk(b"IEND", b"")


@pytest.mark.claim("A film's header cannot ask for all memory")
@pytest.mark.skipif(sys.platform != "linux", reason="reads Linux's own count of a process' memory")
def test_a_header_cannot_ask_for_all_memory(tmp_path):
    """Catches: probing that fills pictures of any size (a gigabyte here); a limit on opening that decoding forgets."""
    path = tmp_path / "huge.mp4"
    path.write_bytes(huge_png(16_000, 16_000))
    # Linux's own count of a process begins anew with its program; that of `resource` begins with its parent's.
    ask = (
        "import sys; from pathlib import Path; from moireid.errors import MediaError\n"
        "from moireid.verifier.video import Film\n"
        "try: list(Film(Path(sys.argv[1])).frames())\n"
        "except MediaError: print(Path('/proc/self/status').read_text())"
    )
    done = subprocess.run([sys.executable, "-c", ask, str(path)], check=True, capture_output=True, text=True)
    peak_kb = int(re.search(r"VmHWM:\s*(\d+)", done.stdout)[1])
    assert peak_kb < 300e3


def test_pictures_beyond_4k_are_refused_with_their_size(tmp_path):
    """Catches: a film of a sixteen-thousand-pixel camera that is refused without a reason; one of 4K that is."""
    for size in ("W4096 H2304", "W7680 H4320", "W9000 H4608"):
        (tmp_path / f"{size}.y4m").write_bytes(f"YUV4MPEG2 {size} F30:1 Cmono\nFRAME\n".encode())
    assert Film(tmp_path / "W4096 H2304.y4m").width == 4096
    with pytest.raises(MediaError, match="7680 x 4320"):
        Film(tmp_path / "W7680 H4320.y4m")
    with pytest.raises(MediaError, match=r"8K|9000 x 4608"):
        Film(tmp_path / "W9000 H4608.y4m")


def short_film(path: Path, count: int) -> Path:
    return written(path, [np.full((64, 64), 40 * k, np.uint8) for k in range(count)], "libx264", "yuv420p")


def test_the_digest_is_of_the_film_that_was_read_and_not_of_its_path(tmp_path, ada):
    """Catches: a film swapped while it is verified, whose digest the verdict on the other one is given."""
    path, other = short_film(tmp_path / "a.mp4", 5), short_film(tmp_path / "b.mp4", 3)
    read, swapped_in = hashlib.sha256(path.read_bytes()).hexdigest(), hashlib.sha256(other.read_bytes()).hexdigest()

    def swap(frame: int, expected: int | None) -> None:
        if frame == 1:
            other.replace(path)

    report = verify(path, Question(ada), progress=swap)
    assert report.frames["read"] == 5 and report.film["sha256"] == read
    assert verify(path, Question(ada)).film["sha256"] == swapped_in
    film = Film(path)
    short_film(tmp_path / "c.mp4", 4).replace(path)
    assert len(list(film.frames())) == 3 and film.described()["sha256"] == swapped_in
