"""The report for people: one page that needs no other file.  Each test states the wrong implementation that it catches.

Reports are put together by hand, on the films of numbers of `test_identity`: tested is what is said of a verdict.
"""

from __future__ import annotations

import base64
import json
import re
from dataclasses import replace
from datetime import UTC, datetime
from functools import cache
from html.parser import HTMLParser

import cv2
import numpy as np
import pytest

from kit.numeric_films import FRAMES, TYPICAL, filmed
from moireid.badge import Badge, badge_from_json
from moireid.provenance import BadgeHolder, Standing
from moireid.question import KnownCamera
from moireid.verifier.decision.judge import Invariant, Segment, judge
from moireid.verifier.explanations.table import in_words
from moireid.verifier.explanations.words import does
from moireid.verifier.fringes.signals import Measurement, measure
from moireid.verifier.identity.decode import Identity
from moireid.verifier.reasons import Reason
from moireid.verifier.report.circumstances import Circumstances
from moireid.verifier.report.live_receipt import LiveReceipt, attached
from moireid.verifier.report.report_page import pictures_of, render_page, report_paths, write_report
from moireid.verifier.session.cover import Cover
from moireid.verifier.session.result import Report
from moireid.verifier.tracking.track import Track

#: Tags of HTML that have no end.
VOID = {"meta", "link", "img", "br", "hr", "input", "source"}
SEGMENTS = (
    Segment(0.5, 4.5, 120, "accept", 0.99, 1.0, 0.8),
    Segment(4.5, 8.5, 0, "inconclusive"),
    Segment(8.5, 9.9, 42, "reject", 0.1, -1.0, 0.7),
)
FINGERPRINT, HEAD = "c0ffee" * 5, "3:" + "cd" * 32
KNOWN = Circumstances(
    datetime(2026, 5, 7, 14, 5, tzinfo=UTC),
    claim="Ada Lovelace",
    standing=Standing(FINGERPRINT, HEAD),
    registry="r.sqlite3",
)
EVIL = "<script>alert('x')</script> & \"Ada\" </title> {{ 7 * 7 }}"


@cache
def judged(text: str) -> tuple[Track, Measurement, Invariant]:
    """Track, measurement and judgement of a film of this badge.json."""
    track = replace(filmed(badge_from_json(text), TYPICAL), frames_read=FRAMES + 3)
    measurement = measure(track, camera=KnownCamera(1450.0))
    camera = replace(measurement.camera, focal_px=1432.1, focal_sd_px=11.2, focal_given=False, shutter_s=0.0123)
    measurement = replace(measurement, camera=camera)
    return track, measurement, judge(measurement.gratings)


def report_of(
    badge: Badge, *, verdict="accept", identity="match", tracked=True, path="no/film.mp4", name: str | None = None
) -> Report:
    """A report on a film of `badge`, of which the verdict, names and paths may be put in."""
    track, measurement, invariant = judged(badge.to_json())
    track = replace(track, snapshot=np.tile(np.arange(60, dtype=np.uint8) * 4, (40, 1)) if tracked else None)
    who = Identity(
        identity,
        (Reason("identity", "pass", badge.id, badge.id, "", f"The badge reads {badge.id}, as claimed."),),
        decoded_id=badge.id,
        claimed_id=badge.id,
        beat_period_mm=20.5,
        expected_beat_period_mm=21.4,
        score=0.98,
    )
    film = {"path": path, "sha256": "ab" * 32, "width": 1920, "height": 1080, "fps": 29.97}
    return Report(
        verdict,
        invariant.reasons + who.reasons,
        invariant,
        who,
        film,
        {"read": FRAMES + 3, "tracked": FRAMES},
        {"total_s": 3.21, "stages": {"decode": 1.0, "find": 2.0}},
        ("colour",),
        replace(track, badge=replace(badge, name=name or badge.name)),
        measurement if tracked else None,
        segments=SEGMENTS if tracked else (),
        cover=Cover(0.8, ((0.0, 1.5), (2.2, 2.9)), 0.7, (0.0, 3.2), ((0.0, 1.5), (2.2, 2.9))) if tracked else None,
    )


def page_of(report: Report, known: Circumstances = KNOWN) -> str:
    """The page of a report, its pictures drawn."""
    return render_page(report.to_json(), pictures_of(report), known)


def plots_in(page: str) -> list[str]:
    """The SVG texts of a page's plots."""
    coded = re.findall(r"data:image/svg\+xml;base64,([^\"]+)", page)
    return [base64.b64decode(one).decode() for one in coded]


class Page(HTMLParser):
    """Reads a page and keeps its open tags, so that a missing or crossed end is an error."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.words: list[str] = []
        self.feed(text)
        self.close()
        assert self.open == [], f"never closed: {self.open}"

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))

    def handle_endtag(self, tag):
        assert self.open and self.open[-1] == tag, f"</{tag}> closes {self.open[-3:]}"
        self.open.pop()

    def handle_data(self, data):
        self.words.append(data)

    @property
    def text(self) -> str:
        """What a person reads, spaces made single."""
        return " ".join(" ".join(self.words).split())


@pytest.fixture(scope="module")
def page(ada) -> str:
    return page_of(report_of(ada))


# The page alone.


@pytest.mark.claim("A report's page asks for nothing from outside")
def test_the_page_asks_for_no_other_file(page):
    """Catches: a font, a script or a picture fetched from elsewhere: it shows who verifies whom; it fails offline."""
    for tag, attributes in Page(page).tags:
        assert tag not in ("script", "link", "iframe", "object", "embed", "base"), tag
        for name, value in attributes.items():
            assert not name.startswith("on"), name
            if name in ("src", "href", "xlink:href", "srcset", "poster", "action", "data", "background"):
                assert value and value.startswith(("data:", "#")), (tag, name, value)
    assert all(target.strip("'\" ").startswith("#") for target in re.findall(r"url\(([^)]*)\)", page))
    assert "@import" not in page


@pytest.mark.claim("No name writes HTML on a report's page")
@pytest.mark.slow
def test_names_and_paths_cannot_write_html(ada):
    """Catches: a template without escaping; a name put into a template that is then rendered again."""
    report = report_of(ada, name=EVIL, path="/tmp/<img src=x onerror=alert(1)>.mp4")
    known = replace(KNOWN, claim=EVIL, read=BadgeHolder(EVIL))
    for shown in (report, mismatched(report)):
        page = page_of(shown, known)
        parsed = Page(page)
        assert all(tag != "script" and "onerror" not in attributes for tag, attributes in parsed.tags)
        assert EVIL in " ".join(parsed.text.split("What to do")[0].split())
        assert "<img src=x onerror=alert(1)>" in parsed.text


# What it says.


def mismatched(report: Report) -> Report:
    """The report on a film of this badge that was claimed to be another's."""
    reason = Reason(
        "identity", "fail", "00", "11", "", "The badge's code is that of another badge than the claimed one."
    )
    who = replace(report.identity, verdict="mismatch", claimed_id="11" * 8, reasons=(reason,))
    return replace(report, verdict="reject", identity=who, reasons=(*report.invariant.reasons, reason))


def test_the_case_stands_at_the_top(ada):
    """Catches: one colour or sign for all verdicts; a headline that is not the page's first."""
    report = report_of(ada)
    pictures = pictures_of(report)
    for verdict, mark in (("accept", "✓"), ("reject", "✗"), ("inconclusive", "?")):
        page = render_page(replace(report, verdict=verdict).to_json(), pictures, KNOWN)
        first = Page(page).text.split("Why")[0]
        assert f"<h1>{mark} " in page and f'class="verdict {verdict}"' in page
        assert all(other not in first for other in {"✓", "✗"} - {mark})


@pytest.mark.slow
def test_live_checks_are_shown_and_are_no_part_of_the_verdict(ada):
    """Catches: a receipt that is attached and on no page; one that changes the headline; a name that writes HTML."""
    report = report_of(ada)
    receipt = LiveReceipt("one-time link", "<b>Ada</b>", "2026-05-07T14:05:00+00:00", "accept", "ef" * 32, True)
    pictures = pictures_of(report)
    page = render_page(attached(report.to_json(), [receipt]), pictures, KNOWN)
    assert "A live check of &lt;b&gt;Ada&lt;/b&gt; about no film in particular was passed" in page
    plain = render_page(report.to_json(), pictures, KNOWN)
    assert "Live checks" not in plain and re.findall("<h1>.*</h1>", page) == re.findall("<h1>.*</h1>", plain) != []


def test_the_table_of_explanations_is_on_the_page(ada, page):
    """Catches: a page that gives a verdict and not what it was weighed against; odds that pass for a probability."""
    report, text = report_of(ada), Page(page).text
    assert len(report.invariant.explanations) > 5
    body = page[page.index('<table class="rivals">') : page.index("</table>", page.index('<table class="rivals">'))]
    assert body.count("<tr") == len(report.invariant.explanations) + 1 and 'class="holds"' in body
    known = [(one.name, {} if one.name == "law" else one.parameters) for one in report.invariant.explanations]
    rows = [does(*one).replace("'", "&#39;") for one in known]
    assert all(words in body for words in rows) and "no probability" in text
    assert in_words(report.to_json()["invariant"]["calibrated_log10"]) in text
    none = page_of(replace(report, invariant=replace(report.invariant, explanations=())))
    assert '<table class="rivals">' not in none and "no probability" not in Page(none).text


def test_the_plots_and_the_picture_are_in_the_page(page, ada):
    """Catches: a plot left out; a picture that is no picture; the plot of the same data twice."""
    picture = next(attributes["src"] for tag, attributes in Page(page).tags if tag == "img")
    kind, content = picture.split(",", 1)
    assert kind == "data:image/png;base64"
    shown = cv2.imdecode(np.frombuffer(base64.b64decode(content), np.uint8), cv2.IMREAD_UNCHANGED)
    assert np.array_equal(shown, report_of(ada).track.snapshot)
    assert len(plots_in(page)) == len(set(plots_in(page))) == 2


# The files.


@pytest.mark.slow
def test_the_json_beside_it_is_the_contract_s(ada, tmp_path):
    """Catches: NaN; rounding apart from that of `verify --json`; the folder of the film, which is private."""
    report = report_of(ada, path="/private/film.mp4")
    report = replace(report, invariant=replace(report.invariant, gain_sd=float("inf")))
    page, data, signals = write_report(report, tmp_path / "new" / "folder")
    assert [page, data, signals] == report_paths(tmp_path / "new" / "folder")

    def refuse(constant: str) -> None:
        raise AssertionError(constant)

    document = json.loads(data.read_text(encoding="utf-8"), parse_constant=refuse)
    assert document["input"].pop("path") == "film.mp4"
    assert document == json.loads(json.dumps(report.to_json())) | {"input": document["input"]}
    assert document["invariant"]["gain_sd"] is None
    assert sorted(p.name for p in (tmp_path / "new" / "folder").iterdir()) == [
        "report.html",
        "report.json",
        "signals.csv",
    ]
