"""Parts of a film that are excused, or move otherwise than its rest.  Next to each test: what it would catch."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from kit.fringe_signals import apart_from, clock, fringe_signal, lasting_noise, trajectory
from moireid.verifier.decision.judge import judge
from moireid.verifier.decision.sheet_gain import DESIGNED
from moireid.verifier.fringes.grating_signal import GratingSignal
from moireid.verifier.identity.decode import Identity
from moireid.verifier.identity.page_scale import mirrored_finding
from moireid.verifier.session.chapters import Chapter, invariant_of
from moireid.verifier.session.overlap import law_through


def chapter(signals: list[GratingSignal], *, page_off: bool = False) -> Chapter:
    """A chapter of these signals, judged."""
    fields: dict[str, Any] = dict.fromkeys(Chapter.__dataclass_fields__)
    fields |= {"signals": tuple(signals), "span_s": (0.0, 5.0), "sheet": DESIGNED}
    fields["identity"] = Identity("match", (mirrored_finding(0.97),) if page_off else ())
    return Chapter(**fields | {"invariant": judge(signals, DESIGNED, page_off=page_off)})


def two_gratings(*, seed: int, own_rad: float = 0.0, **how: Any) -> list[GratingSignal]:
    """A true grating, and one that should be at rest, with so much motion of its own."""
    law, frames = trajectory(seed, 150), 150
    rest, other = 0.05 * apart_from(law, 5), own_rad * apart_from(law, 7)
    first = fringe_signal(1.2 * law, 1.2 * law + lasting_noise(frames, seed=seed), **how)
    return [first, fringe_signal(rest, rest + other + lasting_noise(frames, seed=seed + 50), **how)]


@pytest.mark.parametrize(
    ("how", "page_off", "verdict"),
    [({}, False, "reject"), ({}, True, "inconclusive")],
)
def test_an_excused_chapter_is_not_averaged_away(how, page_off, verdict):
    """Catches: a forged half minute that is seen as if its page were off, in a film that is accepted."""
    true = [chapter(two_gratings(seed=seed)) for seed in range(20, 44)]
    assert invariant_of(true).verdict == "accept"
    forged = chapter(two_gratings(seed=7, own_rad=0.3, **how), page_off=page_off)
    assert forged.invariant.verdict == verdict
    assert invariant_of([*true, forged]).verdict == verdict
    harmless = chapter(two_gratings(seed=7, **how), page_off=page_off)
    assert invariant_of([*true, harmless]).verdict == "accept"


def test_a_chapter_that_noise_alone_excuses_is_not_averaged_away():
    """Catches: a forged half minute whose contrasts tremble as much as its rows move apart, in a film that is accepted;
    the same beside a true badge."""

    def film(seed: int, size: float, rows_rad: float, noise_rad: float) -> Chapter:
        law = size * trajectory(seed, 300)
        signal = fringe_signal(law, law + lasting_noise(300, seed=seed), rows_rad=rows_rad)
        return chapter([replace(signal, strip_sd_rad=np.full(2, 0.03), strip_noise_rad=np.full(2, noise_rad))])

    true = [film(seed, 6.0, 0.01, 0.01) for seed in range(20, 39)]
    harmless = film(7, 0.4, 0.01, 0.15)
    assert not harmless.breaks_law
    assert invariant_of([*true, harmless]).verdict == "accept"
    assert film(7, 0.4, 0.3, 0.01).invariant.verdict == "reject"
    trembling = film(7, 0.4, 0.3, 0.15)
    assert trembling.invariant.verdict == "inconclusive"
    assert trembling.breaks_law
    assert invariant_of([*true, trembling]).verdict == "inconclusive"


@pytest.mark.parametrize(
    ("gain", "noise_rad", "how", "page_off", "breaks"),
    [
        (1.0, 0.01, {}, False, False),
        (1.0, 0.15, {}, False, False),
        (-1.0, 0.01, {}, False, True),
        (0.5, 0.01, {}, False, True),
        (-1.0, 0.01, {}, True, True),
    ],
)
def test_a_badge_whose_code_is_hidden_may_be_the_judged_one_where_its_fringes_are_not_as_usual(
    gain, noise_rad, how, page_off, breaks
):
    """Catches: half the gain, or a page that is off, while the code is painted over and no true badge is seen, in a
    film that is accepted; a true badge or a noisy one held against the judged one."""
    law = 1.2 * trajectory()
    film = fringe_signal(law, gain * law + lasting_noise(size=noise_rad), **how)
    assert chapter([film], page_off=page_off).breaks_law is breaks


@pytest.mark.parametrize("gain", [0.75, 1.25, 1.0])
def test_fringes_move_before_the_face_as_in_the_rest_of_the_film(gain):
    """Catches: another gain for some seconds, which each frame's room and the whole film's gain hide."""
    law, times = 1.5 * trajectory(6, 900), clock(900)
    begins = [k for k in range(20, 730) if abs(law[k + 150] - law[k]) < 0.05 and np.ptp(law[k : k + 150]) > 0.3]
    begin = min(begins, key=lambda k: float(np.ptp(law[k : k + 150])))
    own, measured = slice(begin, begin + 150), law.copy()
    measured[own] = law[begin] + gain * (law[own] - law[begin])
    film = chapter([fringe_signal(law, measured + lasting_noise(900, seed=7), tangent_sd=0.005, phase_sd=0.08)])
    assert film.invariant.verdict == "accept"
    reason, share = law_through((times[begin], times[begin + 150]), [film])
    assert share is not None and share > 0.97
    assert reason.level == ("pass" if gain == 1.0 else "undecided")
    renamed = replace(film, invariant=replace(film.invariant, gain_ratio=gain))
    assert law_through((times[begin], times[begin + 150]), [renamed])[0].level == "pass"


@pytest.mark.parametrize(("noise_rad", "level"), [(0.01, "fail"), (0.3, "undecided")])
def test_noise_does_not_excuse_what_happens_before_the_face(noise_rad, level):
    """Catches: fringes off the law for the seconds that matter, which contrasts that tremble all film long excuse."""
    law, times = 1.5 * trajectory(8, 1500), clock(1500)
    begin = max(range(300, 1090), key=lambda k: float(law[k : k + 110].std()))
    own, measured = slice(begin, begin + 110), law + lasting_noise(1500, seed=7)
    measured[own] += 0.26 * np.clip(1.4 * np.sin(4 * np.pi * np.arange(110) / 110), -1, 1)
    signal = fringe_signal(law, measured, tangent_sd=0.005, phase_sd=0.04)
    film = chapter([replace(signal, strip_noise_rad=np.full(2, noise_rad))])
    assert film.invariant.verdict == "accept"
    assert law_through((times[begin], times[begin + 109]), [film])[0].level == level
