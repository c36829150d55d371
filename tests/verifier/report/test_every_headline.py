"""Each reason code from evidence that causes it, and each headline that the page of a report can have.

The codes are read from the source, so one that is new has no evidence here, and the test fails until it has.
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from kit.fringe_signals import FRAMES, fringe_signal, lasting_noise, trajectory
from kit.report_documents import ADA, ASKED, LAW_ROW, REGISTRY, document, finding, rival
from moireid.asbuilt import AsBuilt
from moireid.badge import Badge
from moireid.idcodes import DecodeResult
from moireid.provenance import BadgeHolder, Exclusion, Provenance, Standing
from moireid.verifier import Question, limits
from moireid.verifier.damage import DamageWatch, claimed_finding
from moireid.verifier.decision import findings, photographs
from moireid.verifier.decision.comparison import GratingComparison
from moireid.verifier.decision.doubts import doubts_of
from moireid.verifier.decision.figures import Figures
from moireid.verifier.decision.judge import Invariant, judge
from moireid.verifier.decision.parts import parts, parts_of
from moireid.verifier.decision.sheet_gain import DESIGNED, gain_reason
from moireid.verifier.explanations.photographs.fringe_spacing import Spacing
from moireid.verifier.explanations.table import Explanation
from moireid.verifier.explanations.words import WORDS
from moireid.verifier.fringes.grating_signal import BeyondPhase, DepthLaw, GratingSignal
from moireid.verifier.identity import decode, page_scale
from moireid.verifier.identity.cell_slip import CellMotion, RowsApart
from moireid.verifier.identity.compare_built import compare_built
from moireid.verifier.identity.decode import Identity
from moireid.verifier.measuring import CELLS_MOVE_RATIO, CELLS_STILL_RATIO, MAX_UNSEARCHED_S
from moireid.verifier.reasons import Reason
from moireid.verifier.report import headline
from moireid.verifier.report.finding_words import GENERAL, RIVALS
from moireid.verifier.report.headline import BARRED, BROKEN, Headline, headline_of
from moireid.verifier.session import badge_session, chapters, check_level, cover, identify, overlap, streaming
from moireid.verifier.session.claim import claim_reasons
from moireid.verifier.timeline import restart_findings
from moireid.verifier.tracking.track import no_track

ROOT = Path(__file__).parents[3]
LAW = 1.2 * trajectory()
ODD = 1.2 * trajectory(7)
#: Files whose reasons get their code from a variable, and the codes that it takes.
FROM_A_TABLE = {
    "compare_built.py": {"as_built_beat", "as_built_offset", "as_built_twist", "as_built_map"},
    "findings.py": set(RIVALS),
    "claim.py": set(BARRED),
}


def codes_in(folder: str, tables: dict[str, set[str]]) -> set[str]:
    """The codes of all reasons that a folder's source makes."""
    found: set[str] = set()
    for path in (ROOT / folder).rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "Reason" and node.args:
                code = node.args[0]
                found |= {str(code.value)} if isinstance(code, ast.Constant) else tables[path.name]
    return found


def signal(measured: np.ndarray = LAW, law: np.ndarray = LAW, **how: Any) -> GratingSignal:
    return fringe_signal(law, measured + lasting_noise(len(law)), **how)


def mean(**figures: float) -> Figures:
    return replace(Figures(), gain_ratio=1.0, excitation_rad=1.2, information=1.0, **figures)


def compared(**more: Any) -> GratingComparison:
    given: dict[str, Any] = {"deviation_rad": 0.0, "limit_rad": 1.0, "possible_rad": 2.0} | more
    return GratingComparison(given.pop("figures", mean()), True, **given)


def troubled(**of_signal: Any) -> Sequence[Reason]:
    """A film that leaves the law, with the honest cause that its signal shows."""
    small = "doubt" in of_signal
    bad = compared(deviation_rad=1.5, doubted=not small, figures=mean(expected_error_rad=0.3 * small))
    open_ = Reason("residual", "undecided", 1.5, 1.0, "rad", "It leaves the law.")
    doubts = doubts_of([(signal(**of_signal), bad)])
    return [open_, *(one for one in (doubts.camera, doubts.small) if one is not None)]


def moved_unseen() -> Sequence[Reason]:
    none, resting = np.zeros(FRAMES), 0.05 * trajectory()
    leap, depth = 3.0 * np.sign(trajectory()), DepthLaw(none, none, none)
    far = BeyondPhase(leap, depth, none.astype(complex), None, none + 1.0 + 0j)
    return findings.evidence([fringe_signal(resting, resting, beyond=far)], mean(), enough=False)


def remaining(name: str) -> Sequence[Reason]:
    row = Explanation(name, -2.0, {"late_s": 0.3, "start_s": 1.0, "end_s": 2.0}, None, True)
    return findings.rivals([row], [(signal(), compared())], Reason("gain", "pass", 1.0, 0.1, "ratio", ""))


def read(found: str | None, claimed: str | None, *, beats: bool | None = True) -> Sequence[Reason]:
    payload = None if found is None else bytes.fromhex(found)
    decoded = DecodeResult(payload, 26, 20 if found is None else 0, 0, 1.0, beats)
    return [decode._compare(decoded, found, claimed, sealed=False)[1]]


def claims(badge: Badge) -> Sequence[Reason]:
    """All notes on a claim: of a file, and of a registry whose name looks like another and was chosen by its line."""
    named = replace(badge, name="Ada\u200b Lovelace", id=badge.id)
    known = Provenance("registry", "Eve", ("Ada L0velace (00)",), line="Editor", others=2)
    match = Identity("match", (), claimed_id=badge.id)
    shown = ((named, known), (badge, replace(known, source="file", file_name="Bo")))
    given = (Question(one, badge_id=badge.id, provenance=of) for one, of in shown)
    return [reason for claim in given for reason in claim_reasons(claim, match)]


def built(badge: Badge) -> Sequence[Reason]:
    """Figures that are others than those of enrolment, by an earlier version, and that change within the film."""
    maps = {"place_maps": ((0.0,) * 4,), "place_map_sd": 0.01}
    known = AsBuilt(badge.id or "", 0.03, 1e-5, 0.0, 0.01, 0.0, 1e-4, 1.0, 0.001, **maps)
    other = replace(known, offset_rad=1.5, place_maps=((0.5,) * 4,))
    claim = Question(badge, badge_id=badge.id, as_built=known, as_built_at="2026-05-03", replaced_at="2026-06-01")
    claim = replace(claim, level="enrolled")
    seen = Identity("match", (), decoded_id=badge.id, claimed_id=badge.id)
    fits = Invariant("accept", (), explanations=(Explanation("law", 0.0, {}, None, True),))
    same = compare_built(known, known, badge)
    return [
        *compare_built(other, known, badge, apart_rad=1.0, apart_sd=0.1).reasons,
        *chapters._judge_built(seen, same, fits, claim)[1],
        *chapters._judge_built(seen, None, fits, claim)[1],
    ]


def enrolled(holds: bool) -> SimpleNamespace:
    return SimpleNamespace(holds=lambda badge_id: holds, alike=lambda parts: [])


def identified(badge: Badge, verdict: str, *, holds: bool) -> Sequence[Reason]:
    seen = Identity("not_claimed", (), decoded_id=badge.id)
    report: Any = SimpleNamespace(invariant=Invariant(verdict, ()), identity=seen, reasons=())  # type: ignore[arg-type]
    return identify.judge(report, enrolled(holds)).reasons


def unreadable_layout(badge: Badge, monkeypatch: pytest.MonkeyPatch) -> Sequence[Reason]:
    from moireid.errors import CodeError

    def refuse(*_: Any, **__: Any) -> None:
        raise CodeError("no code")

    monkeypatch.setattr(identify, "verify", refuse)
    return identify.identify(Path("a.mp4"), [badge], enrolled(True)).reasons


def several(badge: Badge) -> Sequence[Reason]:
    parts: Any = [
        SimpleNamespace(identity=Identity("not_claimed", (), decoded_id=one), built_reasons=()) for one in ("aa", "bb")
    ]
    return chapters.identity_of(parts)[0].reasons


def carried(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Sequence[Reason]:
    from moireid.attest import film_credentials

    monkeypatch.setattr(film_credentials, "may_carry", lambda film: True)
    monkeypatch.setattr(film_credentials, "_read_apart", lambda film: {"state": "Valid", "signer": "Ada"})
    return [Reason(**one) for one in film_credentials.with_carried({"reasons": []}, tmp_path)["reasons"]]


def evidence(badge: Badge, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Sequence[Reason]]:
    """What causes each reason, undecided where it can be that."""
    yield [chapters._badge_absent(replace(no_track(badge, 300, (640, 480)), times_s=np.arange(9) / 30))]
    yield judge([fringe_signal(LAW, LAW, phase_sd=np.inf)]).reasons
    yield judge([signal(0.05 * LAW, 0.05 * LAW)]).reasons
    yield moved_unseen()
    yield findings.evidence([signal(stray_share=0.9, covered_share=0.9, focal_at_limit=True)], mean(), enough=True)
    yield judge([signal()]).reasons
    yield judge([signal(ODD)]).reasons
    yield [gain_reason(1.1, 0.4, DESIGNED, (0.2, 9.0))]
    yield judge([replace(signal(0.4 * LAW), lens_room=(0.2, 1.0))]).reasons
    yield [page_scale.mirrored_finding(0.97)]
    yield [findings.residual([compared(deviation_rad=1.5)], prove=True)]
    yield [parts(parts_of([mean()], RowsApart(1.0, 1.0, 0.0)))]
    yield troubled(lasting_px=99.0)
    yield troubled(mixed_share=0.9)
    yield troubled(doubt=9.0)
    yield from (remaining(name) for name in RIVALS)
    yield [photographs._at_one_distance(Spacing(0.0, 0.01))]
    turned = SimpleNamespace(seen=True, photographs=3, certain=0.5)
    yield [photographs._in_turn(turned)]  # type: ignore[arg-type]
    soft = SimpleNamespace(missed=True, surplus=0.0, limit=1.0)
    yield [photographs._superposed(soft)]  # type: ignore[arg-type]
    yield read(None, ADA)
    yield read(ADA, badge.id)
    yield read(ADA, ADA, beats=None)
    half = (CELLS_STILL_RATIO + CELLS_MOVE_RATIO) / 2
    yield decode._cells_move(CellMotion(half, half, 0.01), ADA)
    yield several(badge)
    yield [Reason(code, "fail", "lost", None, "", "It does not count.") for code in BARRED]
    yield claims(badge)
    yield built(badge)
    yield carried(tmp_path, monkeypatch)
    yield badge_session.others_note(1, {ADA}, {"frame": 0, "corners_px": [[0, 0]] * 4})
    judged: Any = SimpleNamespace(read=lambda: set(), judged_s=[], region=lambda by: None)
    yield badge_session.broken_findings(judged, [badge_session.BrokenBadge(frozenset(), ((0.0, 9.0),), None)])
    yield cover.cover_findings(cover.Cover(0.1, (), 9.0, present_share=0.1), 0.5)
    searched: Any = SimpleNamespace(_view=SimpleNamespace(unsearched_s=MAX_UNSEARCHED_S + 1))
    yield streaming.Verifier.long_unsearched.fget(searched)  # type: ignore[attr-defined]
    lost = DamageWatch(marks=bytearray(90), lost=9)
    yield lost.findings(None)
    yield [claimed_finding(), Reason("tracks", "undecided", 2.0, 1.0, "tracks", "The file has 2 video tracks.")]
    yield restart_findings(1, limits.WINDOW_FRAMES, limits.WINDOW_FRAMES)
    yield check_level.level_finding("live", "record", "not_known")
    yield [overlap._no_face(9), overlap._agreement(90, 1, None)]
    yield [overlap._long_enough(SimpleNamespace(longest=(0.0, 0.1)))]  # type: ignore[arg-type]
    yield identified(badge, "accept", holds=False)
    yield identified(badge, "reject", holds=True)
    yield unreadable_layout(badge, monkeypatch)


@pytest.fixture
def caused(ada: Badge, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[Reason]:
    return [reason for reasons in evidence(ada, tmp_path, monkeypatch) for reason in reasons]


def test_each_code_of_a_report_is_caused_and_has_words_of_its_own(caused: list[Reason]) -> None:
    """Catches: a code that is new, or that nothing causes any more; an inconclusive film whose headline is the general
    one; a count above its total."""
    assert {reason.code for reason in caused} == codes_in("src/moireid", FROM_A_TABLE)
    for reason in caused:
        assert reason.text.endswith((".", "?")) and not reason.text[0].islower(), reason
        if reason.unit in ("frames", "symbols", "share") and isinstance(reason.measured, float):
            assert reason.measured >= 0 and (reason.unit != "share" or reason.measured <= 1)
        if reason.level == "undecided":
            found = headline_of(document("inconclusive", reason.to_json(), law="inconclusive"), ASKED)
            assert found.title.startswith("Cannot tell: ") and GENERAL.because not in found.title, reason
        if reason.level == "fail":
            found = headline_of(document("reject", reason.to_json(), law="inconclusive"), ASKED)
            assert found.title != "Not accepted", reason


def read_by(name: str, **how: Any) -> Any:
    return replace(ASKED, read=BadgeHolder(name, **how))


def cases() -> Iterator[tuple[dict[str, Any], Any]]:
    """A report, and its circumstances, for each headline of `headline.py`."""
    bundle = replace(ASKED, standing=Standing("c0ffee" * 5, REGISTRY.head, expires="2026-05-12T08:00:00Z"))
    yield document("accept") | {"finding": "found", "found_id": ADA, "found_name": "Ada"}, ASKED
    yield document("accept", identity="not_claimed"), ASKED
    yield document("accept", claim_source="file"), ASKED
    yield document("accept"), bundle
    yield document("inconclusive", finding("motion", "undecided"), law="inconclusive"), ASKED
    yield document("inconclusive"), ASKED
    for code in BARRED:
        yield document("reject", finding(code, measured="2026-05-03")), ASKED
        yield document("reject", finding(code)), replace(ASKED, barred=Exclusion(code, "2026-05-03", "lost"))  # type: ignore[arg-type]
    for name in ("still", "drift", "late", "place"):
        table = [LAW_ROW, rival(name, -9.0)]
        yield document("reject", finding("residual"), law="reject", explanations=table), ASKED
    for code in BROKEN:
        yield document("reject", finding(code, measured=-4.0), law="reject"), ASKED
    for code in ("gain", "cells_move", "name", "enrolled", "identities", "beats", "identity", "built", "odd"):
        yield document("reject", finding(code, measured=0.5), identity="mismatch"), ASKED
    another = document("reject", finding("identity"), identity="mismatch")
    yield another, read_by("Ada Lovelace")
    yield another, read_by("Sarah Example", line="Editor")
    gone = read_by("Ada", barred=Exclusion("revoked", "2026-05-03", "lost"))
    yield document("accept", finding("enrolled")) | {"finding": "nobody", "found_id": None}, gone


def test_each_headline_in_the_source_has_a_case(monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: a headline that was added and that no report here has."""
    lines: set[int] = set()

    def noted(*given: Any) -> Headline:
        lines.add(sys._getframe(1).f_lineno)
        return Headline(*given)

    monkeypatch.setattr(headline, "Headline", noted)
    titles = set()
    for report, known in cases():
        found = headline_of(report, known)
        titles.add(found.title)
        assert found.title and found.advice.endswith((".", "?")) and found.text.endswith("."), found
    tree = ast.parse(Path(headline.__file__).read_text(encoding="utf-8"))
    calls = (node for node in ast.walk(tree) if isinstance(node, ast.Call))
    assert {node.lineno for node in calls if getattr(node.func, "id", "") == "Headline"} == lines
    for words in (*(WORDS[name].does for name in ("still", "drift", "late", "place")), *BROKEN.values()):
        assert any(words in title for title in titles), words
