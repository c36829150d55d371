"""What a process answers that a film has taken over.  Each test names the wrong implementation it catches."""

from __future__ import annotations

import copy
import hashlib
import random
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from kit.coded_films import first_frames
from kit.places import FILMS
from moireid import __version__
from moireid.badge import Badge, load_badge
from moireid.cli.main import moireid
from moireid.errors import MediaError
from moireid.provenance import Revocation
from moireid.reading import film_reader
from moireid.reading.film_reports import judged_film
from moireid.verifier import Question, verify

BADGE = FILMS / "badge.json"


class TakenOver(film_reader.Reader):
    """A reader that answers what the attacker likes."""

    sealed = ("calls",)

    def __init__(self, report: object, **more: object) -> None:
        super().__init__()
        self.said = {"result": report} | more

    def read(self, order, progress):
        return super().read(lambda _: iter([copy.deepcopy(self.said)]), progress)


@pytest.fixture(scope="module")
def film(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The beginning of a true film."""
    return first_frames(FILMS / "genuine_1.0m.mp4", tmp_path_factory.mktemp("film") / "film.mp4", 70)


@pytest.fixture(scope="module")
def honest(film: Path) -> dict[str, Any]:
    """Its report, as an honest process answers it."""
    return verify(film, Question(load_badge(BADGE))).to_json()


def test_what_a_film_cannot_show_is_stated_by_this_process(film: Path, ada: Badge, honest: dict[str, Any]) -> None:
    """Catches: a signed report with a live check, a version or another film's path that a film made up."""
    lies = {"live_checks": [{"verdict": "accept"}], "moireid": "99.9"}
    input_ = honest["input"] | {"path": "/secret/other.mp4"}
    said = TakenOver(honest | lies | {"input": input_})
    found = judged_film(film, Question(ada, ada.id), said, lambda *_: None).result
    assert "live_checks" not in found and found["moireid"] == __version__
    assert found["input"]["path"] == str(film)
    assert found["input"]["sha256"] == hashlib.sha256(film.read_bytes()).hexdigest()


def test_another_film_s_digest_is_refused(film: Path, ada: Badge, honest: dict[str, Any]) -> None:
    """Catches: a film that was exchanged while it was judged."""
    other = honest | {"input": honest["input"] | {"sha256": "0" * 64}}
    with pytest.raises(MediaError, match="changed while it was judged"):
        judged_film(film, Question(ada, ada.id), TakenOver(other), lambda *_: None)


def test_a_badge_that_no_longer_counts_is_never_accepted(film: Path, ada: Badge, honest: dict[str, Any]) -> None:
    """Catches: a revocation that only the process knows of that reads the film."""
    barred = Revocation("2026-01-01T00:00:00Z", "lost")
    with pytest.raises(MediaError, match="no longer counts"):
        judged_film(film, Question(ada, ada.id, barred=barred), TakenOver(honest), lambda *_: None)


def places(document: Any, before: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Every place of a report, by its keys and numbers."""
    inner = document.items() if isinstance(document, dict) else enumerate(document)
    for key, value in inner:
        yield (*before, key)
        if isinstance(value, (dict, list)):
            yield from places(value, (*before, key))


VALUES = (None, [], {}, "\x1b[2J", -1, 1e300, True, [[1]], {"a": 1}, 10**30, "x" * 10_000)


def spoilt(report: dict[str, Any], place: tuple[Any, ...], value: object) -> dict[str, Any]:
    made = copy.deepcopy(report)
    inner = made
    for key in place[:-1]:
        inner = inner[key]
    if value is Ellipsis:
        del inner[place[-1]]
    else:
        inner[place[-1]] = value
    return made


def judge_as(monkeypatch: pytest.MonkeyPatch, reader: TakenOver) -> Callable[..., Any]:
    """The command, with a reader that answers what the attacker likes."""

    @contextmanager
    def instead(films, *, unsealed=False):
        yield reader

    monkeypatch.setattr(film_reader, "film_reader", instead)
    return lambda *words: CliRunner().invoke(moireid, [*map(str, words)])


@pytest.mark.claim("A report from a taken-over process is checked before it counts")
def test_a_malformed_report_ends_in_a_sentence(
    film: Path, honest: dict[str, Any], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Catches: an answer that ends in an internal error, steers the terminal, or is shown as a verdict."""
    draw = random.Random(5)
    cases = [(place, value) for place in places(honest) for value in (*VALUES, ...)]
    whole = [((), value) for value in (None, [], "x", {}, 3)]
    for number, (place, value) in enumerate([*draw.sample(cases, 150), *whole]):
        said = spoilt(honest, place, value) if place else value
        run = judge_as(monkeypatch, TakenOver(said))
        form = draw.choice([["--json"], [], ["--report", str(tmp_path / str(number))]])
        done = run("verify", film, "--badge", BADGE, *form)
        assert done.exit_code in (0, 1, 2, 3), (place, value, done.exception)
        assert "inside moireid" not in done.output and "\x1b" not in done.output, (place, value, done.output)
        assert done.exit_code != 2 or done.stderr.count("\n") == 1, (place, value, done.output)
        if not place or (place[0] in ("verdict", "reasons", "input", "frames") and value is Ellipsis):
            assert done.exit_code == 2, (place, value)


@pytest.mark.parametrize(
    "more",
    [
        {"files": {"law.svg": "no base64"}},
        {"files": {"../../page.html": ""}},
        {"files": [1]},
        {"frame_s": "x"},
        {"signals": 3},
    ],
)
def test_malformed_pictures_end_in_a_sentence(
    film: Path, honest: dict[str, Any], more: dict[str, Any], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Catches: a picture's name or content that ends in an internal error."""
    run = judge_as(monkeypatch, TakenOver(honest, pictures=more))
    done = run("verify", film, "--badge", BADGE, "--report", tmp_path / "out")
    assert done.exit_code == 2 and "answers what no film shows" in done.stderr, done.output
    assert not (tmp_path / "out").exists() or not list((tmp_path / "out").iterdir())


def test_an_identification_is_held_to_its_schema(
    film: Path, ada: Badge, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Catches: a finding of an attacker's own spelling, which ends in an internal error; one who is found, though no
    one holds that id, or it is none, which would reach the registry's queries."""
    monkeypatch.setenv("MOIREID_KEYS", str(tmp_path / "keys"))
    monkeypatch.setenv("MOIREID_SEEN", str(tmp_path / "seen.sqlite3"))
    from moireid.registry import open_registry

    url = f"sqlite:///{tmp_path}/people.sqlite3"
    with open_registry(url, create=True) as registry:
        registry.enroll(ada)
    reason = {"code": "badge_absent", "level": "undecided", "measured": 0, "limit": 1, "unit": "", "text": "None seen."}
    sound = {"finding": "inconclusive", "found_id": None, "reasons": [reason]}
    for said, code in (
        (sound, 3),
        ({}, 2),
        (sound | {"finding": "perhaps"}, 2),
        (sound | {"found_id": [1]}, 2),
        (sound | {"found_id": "xy"}, 2),
        (sound | {"finding": "found"}, 2),
        (sound | {"finding": "found", "found_id": "0123abcd"}, 1),
        (sound | {"finding": "found", "found_id": ada.id}, 0),
        (sound | {"reasons": [{"code": 1}]}, 2),
        (sound | {"verdict": "accept"}, 2),
    ):
        done = judge_as(monkeypatch, TakenOver(said))("identify", film, "--registry", url)
        assert done.exit_code == code and "inside moireid" not in done.output, (said, done.output)
