"""Does the third harmonic turn with the fringes?  Beside each test: what it would catch."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from kit.photographed import FRAMES, LAW, TYPICAL, found_in, laid_over, noise_of, signal
from moireid.badge import Cell, Grating, Lens
from moireid.lenticule import view_response
from moireid.verifier.explanations.photographs.third_harmonic import ThirdHarmonic, third_harmonic_of
from moireid.verifier.fringes.beyond_phase import expected_overtone
from moireid.verifier.limits import WINDOW_FRAMES

WIDE = LAW / np.ptp(LAW)


def turning(overtone: np.ndarray, law: np.ndarray, expected: np.ndarray | None = None) -> ThirdHarmonic:
    """What turns with fringes that are measured without an error."""
    found = third_harmonic_of(signal(overtone, law=law, measured=law, expected=expected))
    assert found is not None
    return found


@pytest.mark.claim("Superposed photographs are found")
@pytest.mark.parametrize(("count", "range_rad"), [*((3, one) for one in (1.5, 3.0, 5.0, 12.6)), (5, 6.0), (6, 6.0)])
@pytest.mark.parametrize("strength", [0.5, 1.0])
def test_photographs_laid_over_each_other_are_seen(count, range_rad, strength):
    """Catches: three photographs a third of a turn apart, whose fundamental is right in any place; five or six, in
    which the third harmonic is nearly gone.
    """
    law = range_rad * WIDE
    found = found_in(signal(laid_over(count, strength, law) + noise_of(0.001, 1), law=law))
    assert found["third_harmonic"].level == "undecided"


@pytest.mark.parametrize("range_rad", [1.2, 3.0, 8.0])
def test_a_badge_s_fringes_have_edges(range_rad):
    """Catches: a true film left open for its dots and its noise."""
    law = range_rad * WIDE
    still = 0.02 * np.exp(-3j * law)
    found = found_in(signal(TYPICAL + still + noise_of(0.003, 1), law=law))
    assert found["third_harmonic"].level == "pass"
    assert found["third_harmonic"].measured == pytest.approx(abs(TYPICAL) - 0.02, rel=0.1)


def test_what_turns_is_told_from_what_stands():
    """Catches: a mean in which what stands still counts, on a course too short for it to come round."""
    law = 1.5 * WIDE
    found = turning(0.1 + 0.3j * np.exp(-3j * law), law)
    assert found.size == pytest.approx(0.1, abs=1e-9) and found.still == pytest.approx(0.3, abs=1e-9)
    assert not found.seen and turning(0.3 + 0.1j * np.exp(-3j * law), law).seen


@pytest.mark.parametrize("expected", [0.1, 0.5, 1.0])
def test_three_photographs_whose_weights_aim_at_the_third_harmonic_mirror_it(expected):
    """Catches: real weights on three photographs, whose third harmonic has one direction: half of it turns.

    From the side little is asked for; an attack passed there (THREATS.md).
    """
    law = 2.5 * WIDE
    wanted = 0.1 * expected * np.exp(0.4j * law)
    size = np.real(wanted * np.exp(3j * law))
    shown = size * np.exp(-3j * law) + noise_of(0.001, 1)
    assert (
        found_in(signal(shown, law=law, expected=expected * np.exp(0.4j * law)))["third_harmonic"].level == "undecided"
    )
    true = wanted + noise_of(0.001, 1)
    assert found_in(signal(true, law=law, expected=expected * np.exp(0.4j * law)))["third_harmonic"].level == "pass"


@pytest.mark.parametrize(
    ("duty", "open_fraction", "expected"),
    [(0.5, None, 1.0), (1 / 3, None, 0.0), (0.25, None, 1.0), (0.5, 0.5, 1.0), (0.5, 1 / 3, 0.0), (0.4, None, 0.618)],
)
def test_lines_of_another_width_owe_less(duty, open_fraction, expected):
    """Catches: a badge made elsewhere, of lines a third of the pitch wide, whose true films stay open for ever."""
    kind = "lenticular" if open_fraction is None else "mask"
    lens = Lens(kind, 0.508, 1.0, 1.56 if open_fraction is None else 1.0, open_fraction=open_fraction)
    share = expected_overtone(lens, lines(duty), np.zeros(FRAMES), np.zeros(FRAMES))
    assert share == pytest.approx(np.full(FRAMES, expected), abs=1e-3)
    law = 4.0 * WIDE
    soft = noise_of(0.0001, 1)
    found = turning(soft, law, share)
    assert found.let_through == pytest.approx(expected, abs=1e-3) and found.visible == (expected > 0)
    assert found_in(signal(soft, expected=share))["third_harmonic"].level == ("undecided" if expected else "note")


@pytest.mark.claim("A picture counts against soft fringes only if its page's edges are sharp enough")
def test_a_soft_picture_is_no_photograph():
    """Catches: true films out of focus left open; a harmonic taken for less; a sharp film of photographs excused, also
    by a third harmonic drawn at random."""
    lens, front, soft = Lens("lenticular", 0.508, 1.0, 1.56), np.zeros(FRAMES), noise_of(0.003, 1)
    for spread, level in ((0.0, "undecided"), (0.1, "undecided"), (0.2, "note")):
        share = expected_overtone(lens, lines(), front, front, spread_cycles=spread)
        assert found_in(signal(soft, expected=share))["third_harmonic"].level == level
    assert found_in(signal(noise_of(0.5, 1)))["third_harmonic"].level == "undecided"
    still = signal(0.05 * np.exp(-3j * LAW) + soft, expected=share)
    assert found_in(still)["third_harmonic"].level == "undecided"
    lens_and_film = third_harmonic_of(signal(TYPICAL * share, expected=share))
    assert lens_and_film is not None and lens_and_film.let_through == pytest.approx(np.exp(-16 * (0.2 * np.pi) ** 2))
    sharp = third_harmonic_of(signal(np.full(FRAMES, TYPICAL) * 0.5, expected=np.full(FRAMES, 0.5 + 0j)))
    assert sharp is not None and sharp.from_front == pytest.approx(abs(TYPICAL), rel=0.01)


def lines(duty: float = 0.5) -> Grating:
    return Grating((0, 0, 1, 1), "x", 0.52, "uniform", (Cell((0, 0, 1, 1), 0.52, 0.0, duty),))


@pytest.mark.parametrize("side", [0.0, 0.4])
def test_a_sheet_seen_from_the_side_owes_what_its_optics_let_through(side):
    """Catches: true films from the side left open, whose third harmonic is weak and turned by the optics."""
    lens = Lens("lenticular", 0.508, 0.96, 1.56)
    tangent = 0.6 + 0.15 * LAW / np.abs(LAW).max()
    expected = expected_overtone(lens, lines(), tangent, np.full(FRAMES, side))
    traced = [view_response(lens, 0.52 / harmonic, tangent, side) for harmonic in (1, 3)]
    kept = np.abs(traced[1] / traced[0])
    front = [abs(view_response(lens, 0.52 / harmonic, 0.0)) for harmonic in (1, 3)]
    assert np.abs(expected) == pytest.approx(kept * front[0] / front[1], rel=0.03, abs=0.01)
    assert np.abs(expected).max() < 0.9
    seen = signal(0.2 * expected + noise_of(0.002, 1), expected=expected)
    found = found_in(seen)
    assert found["third_harmonic"].level == "pass"
    # Photographs of that badge, superposed, owe the same share as from the front.
    found = found_in(signal(laid_over(3, 1.0) * np.abs(expected) + noise_of(0.0005, 1), expected=expected))
    assert found["third_harmonic"].level == "undecided"


def test_unread_frames_do_not_count_and_few_frames_tell_nothing():
    """Catches: the noise of unread frames in the harmonic; a fit to a handful of frames, which leaves no noise."""
    overtone, sd = np.full(FRAMES, TYPICAL), np.full(FRAMES, 0.01)
    overtone[WINDOW_FRAMES:], sd[WINDOW_FRAMES:] = 5.0, np.inf
    unread = replace(signal(overtone), phase_sd_rad=sd)
    found = third_harmonic_of(unread)
    assert found is not None and abs(found.size) == pytest.approx(abs(TYPICAL), rel=0.1)
    assert third_harmonic_of(unread.part(slice(1, None))) is None
    assert third_harmonic_of(replace(unread, beyond=None)) is None
