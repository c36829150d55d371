"""Files of which players may show other pictures than those judged.  Each test names the fault that it catches."""

from __future__ import annotations

import json
import struct
from fractions import Fraction
from itertools import permutations, product
from pathlib import Path

import av
import numpy as np
import pytest
from click.testing import CliRunner

import moireid as mo
from kit.coded_films import written
from kit.damaging import PICTURES, TS, Part, joined, recoded, with_box, with_edits
from kit.signing import new_key, pem_of, public_pem_of
from moireid.badge import Badge, load_badge
from moireid.cli.main import moireid
from moireid.errors import MediaError
from moireid.verifier import Film, Question, Report, identify, verify
from moireid.verifier.session.capture import capture_as_built
from moireid.verifier.video import OPENING

DEFAULT, COVER, FORCED = 1, 1024, 64


@pytest.fixture(scope="module")
def badge(films: Path) -> Badge:
    return load_badge(films / "badge.json")


@pytest.fixture(scope="module")
def parts(films: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """A true film, a forged one and a still picture, in H.264, and the two films in VP9."""
    folder = tmp_path_factory.mktemp("parts")
    made = {}
    for name, film in (("true", "genuine_1.0m.mp4"), ("forged", "forged_drift_1.0m.mp4")):
        made[name] = recoded(films / film, folder / f"{name}.mp4", "libx264", gop=250)
        made[f"{name}_vp9"] = recoded(films / film, folder / f"{name}.webm", "libvpx-vp9", gop=250)
    grey = np.full((96, 128), 90, np.uint8)
    made["still"] = written(folder / "still.mp4", [grey], "libx264", "yuv420p")
    made["jpeg"] = recoded(films / "genuine_1.0m.mp4", folder / "jpeg.avi", "mjpeg", frames=1)
    return made


def found(report: Report) -> list[tuple[str, str]]:
    return [(reason.code, reason.level) for reason in report.reasons if reason.code in ("tracks", "damaged")]


@pytest.mark.claim("A file of two tracks is judged only as asked")
@pytest.mark.parametrize(
    "suffix", ["mp4", pytest.param("webm", marks=pytest.mark.slow), pytest.param("ts", marks=pytest.mark.slow)]
)
def test_two_tracks_are_judged_only_as_asked(parts, badge, tmp_path, suffix):
    """Catches: the first track, the default one or the largest one judged, where a player shows the other."""
    kind = "_vp9" if suffix == "webm" else ""
    for (number, order), flags in product(
        enumerate(permutations((f"true{kind}", f"forged{kind}"))), product((0, DEFAULT), repeat=2)
    ):
        both = [Part(parts[name], flag) for name, flag in zip(order, flags, strict=True)]
        film = joined(both, tmp_path / f"{number}{flags[0]}{flags[1]}.{suffix}")
        report = verify(film, Question(badge))
        assert report.verdict == "inconclusive" and [one.code for one in report.reasons] == ["tracks"]
        tracks = report.to_json()["input"]["tracks"]
        assert [track["index"] for track in tracks] == [0, 1] and not any(track["chosen"] for track in tracks)
    for track, name in enumerate(order):
        report = verify(film, Question(badge, track=track))
        assert report.verdict == ("accept" if name.startswith("true") else "reject")
        assert found(report) == [("tracks", "note")]
        assert [one["chosen"] for one in report.to_json()["input"]["tracks"]] == [track == 0, track == 1]


@pytest.mark.parametrize("first", ["still", "jpeg"])
def test_a_picture_as_the_first_track_is_a_track(parts, badge, tmp_path, first):
    """Catches: a film that is called too short for its first track, of one picture; the film itself judged unasked."""
    film = joined([Part(parts[first]), Part(parts["true"], DEFAULT)], tmp_path / "film.mkv")
    report = verify(film, Question(badge))
    assert report.verdict == "inconclusive" and [one.code for one in report.reasons] == ["tracks"]
    assert verify(film, Question(badge, track=1)).verdict == "accept"


def test_a_second_programme_is_a_track_though_it_begins_late(parts, badge, tmp_path):
    """Catches: a transport stream that goes on with other pictures, which FFmpeg does not know as it opens it."""
    one = joined([Part(parts["true"])], tmp_path / "one.ts").read_bytes()
    other = bytearray(joined([Part(parts["forged"])], tmp_path / "other.ts").read_bytes())
    for place in range(0, len(other), TS):
        if (other[place + 1] & 0x1F) << 8 | other[place + 2] == PICTURES:
            other[place + 2] += 5
    film = tmp_path / "film.ts"

    def levels(film):
        read = Film(film)
        assert list(read.frames())
        return [reason.level for reason in read.findings() if reason.code == "tracks"]

    film.write_bytes(one + other)
    assert levels(film) == ["undecided"]
    # A byte too many, after which the packets begin elsewhere.
    film.write_bytes(one + b"\0" + other)
    assert levels(film) == ["undecided"]
    film.write_bytes(one)
    assert levels(film) == []


def test_a_track_that_is_met_as_the_file_is_read_is_a_track(tmp_path, monkeypatch):
    """Catches: a programme stream that shows other pictures in its middle, where FFmpeg does not look as it opens it;
    a traceback of PyAV at its end.
    """
    made = []
    for seed in range(2):
        noise = np.random.default_rng(seed).integers(0, 255, (30, 96, 128), np.uint8)
        with av.open(str(tmp_path / "one.vob"), "w") as container:
            stream = container.add_stream("mpeg2video", rate=30)
            stream.width, stream.height, stream.pix_fmt, stream.options = 128, 96, "yuv420p", {"qmax": "2"}
            for picture in noise:
                container.mux(
                    stream.encode(av.VideoFrame.from_ndarray(picture, format="gray").reformat(format="yuv420p"))
                )
            container.mux(stream.encode(None))
        made.append((tmp_path / "one.vob").read_bytes())
    one, other = made[0], made[1].replace(b"\0\0\1\xe0", b"\0\0\1\xe1")
    film = tmp_path / "film.vob"
    film.write_bytes(one + other + one)
    monkeypatch.setattr("moireid.verifier.video.OPENING", OPENING | {"probesize": "100000"})
    for track, level in ((None, "undecided"), (0, "note")):
        read = Film(film, track=track)
        assert read.tracks.findings == () and sum(1 for _ in read.frames()) == 60
        assert [(reason.code, reason.level) for reason in read.findings()] == [("tracks", level)]
    film.write_bytes(one + one)
    read = Film(film)
    assert sum(1 for _ in read.frames()) == 60 and read.findings() == ()


def test_an_index_that_lists_other_pictures_is_said(tmp_path):
    """Catches: an AVI whose pictures follow one another, as FFmpeg reads them, while its index names those of another
    film, within a part that is skipped, as players of the index show them; an ordinary or a cut AVI doubted.
    """
    pictures = [np.full((96, 128), 40 + number, np.uint8) for number in range(40)]
    data = written(tmp_path / "whole.avi", pictures, "mpeg4", "yuv420p").read_bytes()
    start, index = data.index(b"movi"), data.rindex(b"idx1")
    hidden = data[start + 4 : index]
    skipped = b"JUNK" + len(hidden).to_bytes(4, "little") + hidden
    other = bytearray(data[index:])
    for entry in range(8 + 16, len(other), 16):
        place = int.from_bytes(other[entry + 8 : entry + 12], "little") + index - start + 4
        other[entry + 8 : entry + 12] = place.to_bytes(4, "little")
    size = (index - start + len(skipped)).to_bytes(4, "little")
    forged = data[: start - 4] + size + data[start:index] + skipped + other
    for name, content, doubts in (("whole", data, 0), ("cut", data[: index * 3 // 4], 0), ("forged", forged, 1)):
        film = tmp_path / f"{name}.avi"
        film.write_bytes(content)
        read = Film(film)
        assert sum(1 for _ in read.frames()) > 10
        assert [reason.level for reason in read.findings() if reason.code == "tracks"] == ["undecided"] * doubts


@pytest.mark.parametrize(
    ("edits", "words"),
    [
        ([(0.0, 4.0)], None),
        ([(-1.0, 0.5), (0.1, 3.9)], None),
        ([(1.0, 3.0)], "hides"),
        ([(0.0, 3.0)], "hides"),
        ([(0.0, 1.0), (2.0, 2.0)], "hides"),
        ([(2.0, 2.0), (0.0, 2.0)], "again"),
        ([(0.0, 4.0), (0.0, 4.0)], "again"),
    ],
)
def test_edits_that_hide_or_repeat_are_said(parts, tmp_path, edits, words):
    """Catches: pictures that one player shows and another does not, which are not judged; each ordinary film doubted,
    as an edit list also says where its pictures begin.
    """
    said = [reason.text for reason in Film(with_edits(parts["true"], tmp_path / "film.mp4", edits)).tracks.findings]
    assert len(said) == (words is not None) and (words is None or words in said[0])


@pytest.mark.parametrize(("first_s", "doubts"), [(0.0, 0), (2.0, 1)])
def test_pictures_before_time_0_are_said(parts, tmp_path, first_s, doubts):
    """Catches: pictures of an MP4 in fragments that its edit list hides, and FFmpeg does not, taken for shown ones."""
    whole = tmp_path / "whole.mp4"
    flags = {"movflags": "frag_keyframe+empty_moov+default_base_moof"}
    with av.open(str(parts["true"])) as given, av.open(str(whole), "w", options=flags) as made:
        stream = made.add_stream_from_template(given.streams.video[0])
        ticks = int(1 / given.streams.video[0].time_base)
        for packet in given.demux(video=0):
            if packet.dts is not None:
                packet.stream = stream
                made.mux(packet)
    edits = struct.pack(">I4sI4sIIIii", 36, b"edts", 28, b"elst", 0, 1, 0, round(first_s * ticks), 1 << 16)
    film = Film(with_box(whole, tmp_path / "film.mp4", (b"moov", b"trak"), edits))
    assert sum(1 for _ in film.frames()) == 120
    said = [(reason.level, reason.measured) for reason in film.findings()]
    assert said == [("undecided", pytest.approx(0.5, abs=0.03))] * doubts


def test_crops_that_some_players_do_are_said(parts, tmp_path):
    """Catches: a badge that is judged in a part of the picture that players cut off; a crop to the whole picture."""
    path = (b"moov", b"trak", b"mdia", b"minf", b"stbl", b"stsd", b"avc1")
    for width, words in ((1280, 0), (800, 1)):
        box = struct.pack(">I4s8i", 40, b"clap", width, 1, 720, 1, 0, 1, 0, 1)
        film = Film(with_box(parts["true"], tmp_path / "film.mp4", path, box))
        assert sum("crop" in reason.text for reason in film.tracks.findings) == words
    wide = written(
        tmp_path / "wide.mkv", [np.zeros((96, 128), np.uint8)] * 2, "libx264", "yuv420p", aspect=Fraction(4, 3)
    )
    assert Film(wide).tracks.findings == ()
    data = wide.read_bytes()
    # The unit of its size, as the left margin.
    assert data.count(b"\x54\xb2\x81\x04") == 1
    wide.write_bytes(data.replace(b"\x54\xb2\x81\x04", b"\x54\xcc\x81\x04"))
    (reason,) = Film(wide).tracks.findings
    assert (reason.code, reason.level) == ("tracks", "undecided") and "crop" in reason.text


def test_ordered_chapters_are_said(parts, tmp_path):
    """Catches: a film whose parts a player shows in another order; chapters that only name its parts doubted."""
    film = tmp_path / "film.mkv"
    with av.open(str(parts["true"])) as given, av.open(str(film), "w") as made:
        made.set_chapters([{"id": 1, "start": 0, "end": 1000, "time_base": Fraction(1, 1000), "metadata": {}}])
        stream = made.add_stream_from_template(given.streams.video[0])
        for packet in given.demux(video=0):
            if packet.dts is not None:
                packet.stream = stream
                made.mux(packet)
    assert Film(film).tracks.findings == ()
    data = film.read_bytes()
    flags = data.index(b"\x45\xdb\x81\x01", data.index(b"\x10\x43\xa7\x70"))
    film.write_bytes(data[:flags] + b"\x45\xdd" + data[flags + 2 :])
    (reason,) = Film(film).tracks.findings
    assert (reason.code, reason.level) == ("tracks", "undecided") and "chapters" in reason.text
    # The table of contents may name chapters anywhere, as behind a byte that is no element.
    ordered = film.read_bytes()
    start = ordered.rindex(b"\x10\x43\xa7\x70")
    film.write_bytes(data + b"\0" + ordered[start : start + 128])
    assert ["chapters" in reason.text for reason in Film(film).tracks.findings] == [True]


def subtitled(source: Path, target: Path, codec: str, flags: int) -> Path:
    with av.open(str(source)) as given, av.open(str(target), "w") as made:
        stream = made.add_stream_from_template(given.streams.video[0])
        words = made.add_stream(codec)
        words.codec_context.subtitle_header = b"[Script Info]\n[V4+ Styles]\nFormat: Name\nStyle: Default\n[Events]\n"
        words.disposition = flags
        for packet in given.demux(video=0):
            if packet.dts is not None:
                packet.stream = stream
                made.mux(packet)
    return target


@pytest.mark.parametrize(
    ("codec", "flags", "said"),
    [("subrip", 0, 0), ("subrip", DEFAULT, 1), ("subrip", FORCED, 1), ("ass", 0, 1), ("dvbsub", 0, 1)],
)
def test_subtitles_that_are_drawn_are_said(parts, tmp_path, codec, flags, said):
    """Catches: a badge that a player draws over the film; subtitles that a viewer has to ask for doubted."""
    film = Film(subtitled(parts["true"], tmp_path / "film.mkv", codec, flags))
    assert len(film.tracks.findings) == said


@pytest.fixture
def both(parts, films, tmp_path, monkeypatch) -> Path:
    """A forged track that every player shows first, and a true one, next to a badge and a key."""
    monkeypatch.chdir(tmp_path)
    Path("badge.json").write_bytes((films / "badge.json").read_bytes())
    key = new_key("ed25519")
    Path("key.pem").write_bytes(pem_of(key))
    Path("pub.pem").write_bytes(public_pem_of(key))
    return joined([Part(parts["forged"], DEFAULT), Part(parts["true"])], tmp_path / "both.mp4")


def said(*words: object, code: int) -> str:
    outcome = CliRunner().invoke(moireid, [str(word) for word in words])
    assert outcome.exit_code == code, outcome.output
    return outcome.output


def test_the_command_names_the_track_and_so_does_the_signature(both):
    """Catches: an option that does not reach the sealed process; a signature of a file without its track."""
    words = said("verify", both, "--badge", "badge.json", code=3)
    assert "players may show other pictures" in words and "(--track)" in words and "no badge" not in words
    said("verify", both, "--badge", "badge.json", "--track", 0, code=1)
    said("verify", both, "--badge", "badge.json", "--track", 5, code=2)
    said("verify", both, "--badge", "badge.json", "--track", 1, "--sign", "key.pem", "--attest", "a.json", code=0)
    words = said("attest", "check", "a.json", "--film", both, "--key", "pub.pem", code=0)
    assert "track 1 of its 2 video tracks was judged" in words
    checked = json.loads(said("attest", "check", "a.json", "--key", "pub.pem", "--json", code=0))
    assert [track["chosen"] for track in checked["film"]["tracks"]] == [False, True]


def test_no_other_way_in_judges_a_track_unasked(both, badge, ada):
    """Catches: a badge found, or figures of enrolment measured, in a track that players do not show."""
    found = identify(both, [badge])
    assert found.finding == "inconclusive" and [reason.code for reason in found.reasons] == ["tracks"]
    with pytest.raises(MediaError, match="2 video tracks"):
        capture_as_built([both], ada)
    assert mo.verify(both, badge="badge.json", pictures=False).verdict == "inconclusive"
    assert mo.verify(both, badge="badge.json", pictures=False, track=1).verdict == "accept"
