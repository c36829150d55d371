"""The badge before the face, on pictures of a person made of a photograph and rendered badges.

Each test states what it would catch.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from kit.payloads import payload_for_name
from kit.report_faults import faults
from moireid.badge import Badge
from moireid.designer import Order, design_badge
from moireid.errors import MissingExtraError
from moireid.question import Question
from moireid.simulate.recording.encode import FilmWriter, recipe_for
from moireid.verifier import verify
from moireid.verifier.measuring import MIN_OVERLAP_S
from moireid.verifier.picture import Frame
from moireid.verifier.report.report_page import write_report
from moireid.verifier.session import faces
from moireid.verifier.session.chapters import Chapter
from moireid.verifier.session.faces import CARRY_S, HIDDEN_S, Box, FaceFollower
from moireid.verifier.session.overlap import OverlapWatch, law_through, overlap_share
from moireid.verifier.session.streaming import Verifier
from moireid.verifier.video import Film
from moireid_lab.bench.live import AT_PX, FACE_MM, SIZE_PX, answer, frames, portrait
from moireid_studio.challenge.challenge import Prompt

#: A call: the badge goes to the left, across the face, and down from there.
CALL = (Prompt("left", 1.0), Prompt("face", 3.0), Prompt("right", 6.5))
LENGTH_S, FPS = 8.0, 24.0


def call(badge: Badge, *, frozen: bool = False) -> Iterator[Frame]:
    course = answer(CALL, FACE_MM, reaction_s=0.0)
    pictures = frames(badge, portrait(), course, length_s=LENGTH_S, fps=FPS, frozen=frozen)
    return (Frame(k, k / FPS, picture) for k, picture in enumerate(pictures))


@pytest.fixture(scope="module")
def badge() -> Badge:
    return design_badge(Order("Ada Lovelace", lens="50lpi"), payload_for_name("Ada Lovelace"))


@pytest.fixture(scope="module")
def films_of_calls(badge: Badge, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """The call as a film, true and with fringes that stand still."""
    folder = tmp_path_factory.mktemp("calls")
    for name, frozen in (("true", False), ("frozen", True)):
        with FilmWriter(folder / f"{name}.mp4", f"{name}.mp4", (1280, 720), FPS, recipe_for(None, 26)) as out:
            for frame in call(badge, frozen=frozen):
                out.write(frame.luma, frame.index)
    return {name: folder / f"{name}.mp4" for name in ("true", "frozen")}


@pytest.fixture(scope="module")
def watched(
    badge: Badge, films_of_calls: dict[str, Path]
) -> tuple[OverlapWatch, Verifier, list[Chapter], list[tuple[float, Box | None]]]:
    verifier, watch, seen = Verifier(Question(badge, badge.id), running=False), OverlapWatch(), []
    for frame in Film(films_of_calls["true"]).frames():
        verifier.push(frame)
        watch.push(frame, verifier.in_view)
        seen.append((frame.time_s, watch.face))
    return watch, verifier, verifier.finish(), seen


@pytest.mark.slow
def test_a_true_badge_before_the_face_is_told_with_its_time(watched):
    """Catches: an overlap reported where there is none, too long, or lost while the badge hides the face."""
    watch, verifier, chapters, _ = watched
    overlap = watch.judge(verifier.judged.tracker, chapters)
    assert overlap.verdict == "accept" and [reason.code for reason in overlap.reasons] == ["overlap", "overlap_law"]
    start, end = overlap.overlaps.longest
    # The badge sets out at 3.0 s, and leaves from 6.5 s on; each takes 0.9 s.
    assert 3.2 < start < 3.9 and 6.5 < end < 7.4
    assert overlap.agreeing == 1.0 and len(overlap.overlaps.spans) == 1


@pytest.mark.slow
def test_the_face_is_found_where_it_is_and_carried_while_it_is_hidden(watched):
    """Catches: boxes of the shrunken picture; a face that is lost as soon as the badge covers it."""
    _, _, _, seen = watched
    x0, y0, x1, y1 = seen[20][1]
    assert [(x0 + x1) / 2, (y0 + y1) / 2] == pytest.approx(AT_PX, abs=0.15 * SIZE_PX)
    assert x1 - x0 == pytest.approx(SIZE_PX, rel=0.25)
    held = [face for time_s, face in seen if 4.2 < time_s < 6.0]
    assert held[0] is not None and len(set(held)) == 1


@pytest.mark.slow
def test_the_law_is_held_frame_by_frame(watched):
    """Catches: a lie while the badge is before the face, drowned in a true film."""
    _, _, chapters, _ = watched
    interval = (4.0, 6.5)
    (signal,) = chapters[0].signals[:1]
    within = (signal.times_s >= 4.5) & (signal.times_s <= 5.5)
    for lie_rad in (0.0, 0.5):
        lied = replace(signal, measured_rad=signal.measured_rad + lie_rad * within)
        reason, share = law_through(interval, [replace(chapters[0], signals=(lied, *chapters[0].signals[1:]))])
        assert reason.level == ("fail" if lie_rad else "pass") and reason.code == "overlap_law"
        assert share == pytest.approx(0.6 if lie_rad else 1.0, abs=0.05)
    unread = replace(signal, phase_sd_rad=np.where(within | (signal.times_s > 5.0), np.inf, signal.phase_sd_rad))
    assert law_through((4.4, 6.5), [replace(chapters[0], signals=(unread,))])[0].level == "undecided"
    assert law_through(interval, [])[0].level == "undecided"


def test_without_the_package_it_is_told_what_to_install(monkeypatch):
    """Catches: a traceback where dlib is not installed."""
    monkeypatch.setattr(faces.importlib, "import_module", lambda name: (_ for _ in ()).throw(ImportError(name)))
    with pytest.raises(MissingExtraError, match=r"install it with: .*\[face\]"):
        FaceFollower()


@pytest.mark.claim("--overlap asks that the badge passes before the face")
@pytest.mark.slow
def test_a_recorded_call_is_judged_with_its_overlap(badge, films_of_calls, tmp_path):
    """Catches: `--overlap` that changes no verdict; a report without it; a film whose lie the overlap passes."""
    report = verify(films_of_calls["true"], Question(badge, badge.id, overlap=True))
    told = report.to_json()
    assert told["verdict"] == "accept" and told["overlap"]["verdict"] == "accept"
    assert told["overlap"]["longest_s"] > 2 * MIN_OVERLAP_S and told["overlap"]["total_s"] < told["overlap"]["face_s"]
    assert faults(told) == []
    page = write_report(report, tmp_path)[0].read_text(encoding="utf-8")
    assert "badge before it" in page and "before the face for" in page
    forged = verify(films_of_calls["frozen"], Question(badge, badge.id, overlap=True))
    assert forged.verdict == "reject" and forged.overlap.verdict == "reject"


def test_shares_are_of_the_smaller_area():
    """Catches: a share of the larger one, by which a small badge never covers; a box that only touches."""
    face = (100.0, 100.0, 200.0, 200.0)

    def board(x: float, y: float, size: float) -> np.ndarray:
        return np.array([[x, y], [x + size, y], [x + size, y + size], [x, y + size]])

    assert overlap_share(board(150, 100, 100), face) == pytest.approx(0.5)
    assert overlap_share(board(120, 120, 40), face) == pytest.approx(1.0)
    assert overlap_share(board(0, 0, 400), face) == pytest.approx(1.0)
    assert overlap_share(board(200, 100, 100), face) == pytest.approx(0.0, abs=1e-6)
    # A mirrored board's corners go round the other way.
    assert overlap_share(board(150, 100, 100)[::-1], face) == pytest.approx(0.5)


def test_a_face_is_not_carried_for_ever():
    """Catches: somebody who has left, before whose empty place a badge is held."""
    empty, person = np.full((720, 1280), 90, np.uint8), portrait()
    for hidden, limit in ((False, CARRY_S), (True, HIDDEN_S)):
        follower = FaceFollower()
        assert follower.follow(person, 0.0) is not None
        assert follower.follow(empty, limit - 0.05, hidden=hidden) is not None
        assert follower.follow(empty, limit + 0.05, hidden=hidden) is None
