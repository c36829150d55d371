"""Films that lost packets: read on, judged where they are sound, and never rejected for it.

Each test names the fault that it catches.
"""

from __future__ import annotations

import random
from collections.abc import Iterator
from fractions import Fraction
from itertools import islice
from pathlib import Path

import av
import numpy as np
import pytest

from kit.damaging import TS, flagged, lost, recoded, with_packets, zeroed
from moireid.badge import Badge, load_badge
from moireid.errors import MediaError
from moireid.verifier import Film, Question, Report, verify
from moireid.verifier.damage import DAMAGED, DamageWatch
from moireid.verifier.limits import MAX_STRAY_SHARE

#: Codecs that take longer than H.264.
SLOWER = ("libx265", "libvpx-vp9")
CONTAINERS = {"libx264": "mp4", "libx265": "mov", "libvpx-vp9": "webm", "mjpeg": "avi"}


@pytest.fixture(scope="module")
def badge(films: Path) -> Badge:
    return load_badge(films / "badge.json")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("damaged")


@pytest.fixture(scope="module")
def sound(films: Path, folder: Path) -> dict[tuple[str, str, int], Path]:
    """True films by codec, container and group of pictures; made when they are first asked for."""

    class Made(dict[tuple[str, str, int], Path]):
        def __missing__(self, key: tuple[str, str, int]) -> Path:
            codec, suffix, gop = key
            self[key] = recoded(films / "genuine_1.0m.mp4", folder / f"{codec}_{gop}.{suffix}", codec, gop=gop)
            return self[key]

    return Made()


def codes(report: Report, level: str) -> list[str]:
    return [reason.code for reason in report.reasons if reason.level == level]


@pytest.mark.parametrize(("codec", "damaged"), [("libx264", 30), ("libvpx-vp9", 20), ("mjpeg", 1)])
def test_a_zeroed_packet_is_read_past(sound, folder, badge, codec, damaged):
    """Catches: a film that is refused for one packet; wrong pictures after it, up to the next key picture, judged."""
    whole = sound[codec, CONTAINERS[codec], 30]
    number = 70 if codec == "libvpx-vp9" else 60
    report = verify(zeroed(whole, folder / f"zeroed{whole.suffix}", number), Question(badge))
    assert report.frames["damaged"] == damaged and report.frames["read"] == 120
    assert report.frames["tracked"] == 120 - damaged
    share = damaged / 120
    assert report.verdict == ("accept" if share <= MAX_STRAY_SHARE else "inconclusive")
    assert codes(report, "undecided") == ([] if share <= MAX_STRAY_SHARE else ["damaged"])
    assert report.to_json()["cover"]["share"] == pytest.approx(1 - share, abs=0.03)
    assert report.to_json()["cover"]["longest_gap_s"] >= (damaged - 1) / 30 - 0.01


def test_wrong_pictures_are_marked_though_none_is_flagged(sound, folder):
    """Catches: damage that ends with the flagged picture; pictures shown before it, and decoded after it, judged."""
    whole, known = sound["libx264", "ts", 30], {}
    for frame in Film(whole).frames():
        known[round(frame.time_s, 3)] = frame.luma[::4, ::4].astype(int)
    packets = whole.stat().st_size // TS
    wrong = hidden = 0
    for seed in range(6):
        places = random.Random(seed).sample(range(packets // 6, packets), 2)
        film = Film(lost(whole, folder / "lost.ts", places))
        frames = list(film.frames())
        for frame, mark in zip(frames, film.damage.marks, strict=True):
            right = known.get(round(frame.time_s, 3))
            is_wrong = right is None or np.mean(np.abs(frame.luma[::4, ::4] - right) > 12) > 5e-4
            wrong += is_wrong
            hidden += mark == DAMAGED
            assert not is_wrong or mark, (seed, frame.index)
    assert 20 < wrong <= hidden < 6 * 60


@pytest.mark.parametrize("codec", ["libx264", "libx265"])
def test_pictures_before_the_first_key_picture_count(folder, codec):
    """Catches: another film before the one that is judged, without a key picture: FFmpeg's libraries drop it without a
    word, and players show it.
    """
    parameters = {"libx264": "intra-refresh=1:keyint=10:bframes=0:threads=1", "libx265": "keyint=300:bframes=0:pools=1"}
    options = {"preset": "ultrafast", codec[3:] + "-params": parameters[codec] + ":scenecut=0:log-level=none"}
    pictures = [np.random.default_rng(number).integers(0, 255, (96, 128, 3), np.uint8) for number in range(40)]
    with av.open(str(folder / "key.mkv"), "w") as made:
        stream = made.add_stream(codec, rate=30)
        stream.width, stream.height, stream.pix_fmt, stream.options = 128, 96, "yuv420p", options
        for picture in pictures:
            made.mux(stream.encode(av.VideoFrame.from_ndarray(picture)))
        made.mux(stream.encode(None))
    with av.open(str(folder / "key.mkv")) as given:
        coded = [bytes(packet) for packet in given.demux(video=0) if packet.size]
    if codec == "libx264":
        # Without the words of the encoder on where it has renewed the whole picture.
        coded = [coded[0], *(_without_words(packet) for packet in coded[1:])]
    late = [*coded[1:], coded[0]]
    film = Film(with_packets(folder / "key.mkv", folder / "late.mkv", lambda number, _: late[number]))
    shown = list(film.frames())
    assert len(shown) == 40 and list(film.damage.marks) == [DAMAGED] * 39 + [0]
    assert [(one.code, one.level) for one in film.findings()] == [("damaged", "undecided")]


def _without_words(packet: bytes) -> bytes:
    """A packet of H.264 without its units of supplemental information."""
    place, kept = 0, b""
    while place < len(packet):
        unit = packet[place : place + 4 + int.from_bytes(packet[place : place + 4], "big")]
        kept += unit if unit[4] & 0x1F != 6 else b""
        place += len(unit)
    return kept


def test_a_film_that_ends_early_is_read_as_far_as_it_goes(sound, folder, badge):
    """Catches: a film that is refused for its end, or of which nothing says that it is cut."""
    for codec in ("mjpeg", "libvpx-vp9"):
        whole = sound[codec, CONTAINERS[codec], 30]
        cut = folder / f"cut{whole.suffix}"
        cut.write_bytes(whole.read_bytes()[: whole.stat().st_size * 3 // 4])
        report = verify(cut, Question(badge))
        assert 80 < report.frames["read"] < 100 and report.verdict == "accept"
        said = [reason.text for reason in report.reasons if reason.level == "note" and "breaks off" in reason.text]
        assert len(said) == 1


def test_a_file_that_cannot_be_read_on_is_judged_so_far(sound, badge, monkeypatch):
    """Catches: a film that is refused for the last packets of its file; one of no pictures that is not."""
    decoded = Film._decoded

    def ends(film: Film, *given: object, **how: object) -> Iterator[av.VideoFrame]:
        yield from islice(decoded(film, *given, **how), left)
        raise av.error.InvalidDataError(1094995529, "Invalid data found when processing input")

    monkeypatch.setattr(Film, "_decoded", ends)
    left = 90
    report = verify(sound["libx264", "ts", 30], Question(badge))
    assert report.frames["read"] == 90 and codes(report, "note").count("damaged") == 1
    left = 0
    with pytest.raises(MediaError, match="after frame 0"):
        verify(sound["libx264", "ts", 30], Question(badge))


@pytest.mark.claim("A flag of damage hides no forged frame")
@pytest.mark.parametrize("codec", ["libx264", pytest.param("libx265", marks=pytest.mark.slow)])
def test_flags_alone_hide_nothing(films, folder, badge, codec):
    """Catches: a forged stretch, or a whole forged film, that is left out as its packets are flagged."""
    forged = recoded(films / "forged_reversed_1.0m.mp4", folder / f"forged_{codec}.ts", codec, gop=30)
    plain = verify(forged, Question(badge))
    for counters in (False, True):
        report = verify(flagged(forged, folder / "flagged.ts", (0.3, 0.6), counters=counters), Question(badge))
        assert report.verdict == plain.verdict == "reject"
        assert report.frames == plain.frames and report.frames["damaged"] == 0
    if codec == "libx264":
        # Where every packet is flagged, a decoder that finds damage by itself finds none.
        marked = flagged(forged, folder / "flagged.ts", counters=True)
        assert verify(marked, Question(badge)).verdict == "reject"


@pytest.mark.slow
def test_flags_alone_accept_nothing(films, folder, badge, sound):
    """Catches: a forged half between true ones that is accepted, as its packets are flagged as damaged."""

    def forged_part() -> Iterator[av.VideoFrame]:
        for part, (first, last) in (("genuine", (0, 60)), ("forged_drift", (60, 180)), ("genuine", (180, 240))):
            with av.open(str(films / f"{part}_1.0m.mp4")) as given:
                yield from (picture for number, picture in enumerate(given.decode(video=0)) if first <= number < last)

    spliced = folder / "spliced.ts"
    with av.open(str(spliced), "w") as made:
        stream = made.add_stream("libx265", rate=60)
        stream.width, stream.height, stream.pix_fmt = 1280, 720, "yuv420p"
        stream.options = {"preset": "ultrafast", "crf": "18", "x265-params": "log-level=none:keyint=30:pools=1"}
        for number, picture in enumerate(forged_part()):
            frame = picture.reformat(1280, 720, "yuv420p")
            frame.pts, frame.time_base, frame.pict_type = number, Fraction(1, 60), 0
            made.mux(stream.encode(frame))
        made.mux(stream.encode(None))
    assert verify(spliced, Question(badge)).verdict != "accept"
    assert verify(flagged(spliced, folder / "marked.ts", (0.2, 0.8)), Question(badge)).verdict != "accept"


class Shown:
    """A picture as a decoder gives it."""

    def __init__(self, *, key: bool = False, corrupt: bool = False) -> None:
        self.key_frame, self.is_corrupt, self.interlaced_frame = key, corrupt, False


def test_damage_lasts_to_the_next_key_picture():
    """Catches: damage by the order in which pictures are shown; a key picture that ends it though it is damaged, or
    before pictures of the group before it.
    """
    watch = DamageWatch("h264")
    watch.frame(0, Shown(key=True))
    for number in (3, 2):
        watch.frame(number, Shown())
    watch.frame(1, Shown(corrupt=True))
    watch.error(5)
    for number in (4, 6):
        watch.frame(number, Shown())
    # Shown before the key picture and decoded after it, from pictures before it.
    watch.frame(8, Shown())
    watch.frame(7, Shown(key=True))
    watch.frame(9, Shown())
    watch.frame(10, Shown(key=True, corrupt=True))
    watch.frame(11, Shown())
    watch.frame(12, Shown(key=True))
    d = DAMAGED
    assert list(watch.marks) == [0, d, d, d, d, d, d, 0, 0, d, d, 0] and (watch.damaged, watch.lost) == (9, 1)


def losses(sound, folder: Path, codec: str, gop: int, seed: int) -> Path:
    """A film that lost packets: two of a transport stream, or the packet of a picture."""
    places = random.Random(seed)
    if codec == "libvpx-vp9":
        whole, gone = sound[codec, "webm", gop], places.randrange(20, 120)
        return with_packets(whole, folder / "lost.webm", lambda number, held: None if number == gone else held)
    whole = sound[codec, "ts", gop]
    packets = whole.stat().st_size // TS
    return lost(whole, folder / "lost.ts", places.sample(range(packets // 6, packets), 2))


@pytest.mark.claim("Lost packets reject no true film")
@pytest.mark.parametrize("codec", ["libx264", *(pytest.param(name, marks=pytest.mark.slow) for name in SLOWER)])
def test_packets_lost_reject_nothing(sound, folder, badge, codec):
    """Catches: a true film rejected for pictures that its decoder made up."""
    for seed in range(3):
        report = verify(losses(sound, folder, codec, 250, seed), Question(badge, badge.id))
        assert report.verdict != "reject" and not codes(report, "fail"), (seed, codes(report, "fail"))
