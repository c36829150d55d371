"""The pitch bands of a printed page, traced through sheets that are right and wrong."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from kit.drawn import geometry
from moireid.badge import Badge, Lens
from moireid.designer import Order, design_badge
from moireid.fabrication.assembly.sketches import GOOD, MIRRORED, fringe_pictures, runs_right
from moireid.fabrication.page.pdf import write_badge_pdf
from moireid.fabrication.page.pitch_bands import ERRORS, look_m
from moireid.lenticule import trace_mm


def design(size_mm: tuple[float, float] | None = None, paper: str = "a4") -> Badge:
    form = None if size_mm else "a6"
    return design_badge(Order("Al", format=form, paper=paper, size_mm=size_mm, range_m=(0.4, 1.05)), bytes(8))


@pytest.fixture(scope="module")
def badge() -> Badge:
    return design()


@pytest.fixture(scope="module")
def bands(badge: Badge, tmp_path_factory: pytest.TempPathFactory) -> list[np.ndarray]:
    """The dark lines of each band as printed, mm (n, 2), from top to bottom."""
    path = tmp_path_factory.mktemp("bands") / "badge.pdf"
    write_badge_pdf(badge, path)
    lines = np.array([rect for rect, grey in geometry(path).fills if not grey and rect[3] < badge.outline_mm[1]])
    return [np.sort(lines[lines[:, 1] == top][:, ::2], axis=0) for top in np.unique(lines[:, 1])]


def brightness(lens: Lens, lines: np.ndarray, away_mm: float, aside_mm: float = 0.0) -> np.ndarray:
    """How light each lens over the lines is, 0 to 1: the share of its rays that land between them."""
    middle = lines.mean()
    across = ((np.arange(64) + 0.5) / 64 - 0.5) * lens.pitch_mm
    axes = np.arange(lines[5, 0], lines[-5, 0], lens.pitch_mm)[:, None]
    landed = axes + trace_mm(lens, across, (axes - middle - aside_mm) / away_mm, np.zeros((1, 1)))[0]
    before = np.searchsorted(lines[:, 0], landed) - 1
    return np.asarray((landed > lines[before, 1]).mean(axis=1))


@pytest.mark.claim("Five bands on the page show the pitch of a lens sheet on this print")
@pytest.mark.parametrize("sheet", ERRORS)
def test_the_band_of_a_sheet_is_the_one_without_fringes(badge: Badge, bands: list[np.ndarray], sheet: float) -> None:
    """Catches: pitches stepped the wrong way or by the wrong share, the eye's distance left out, bands scaled."""
    lens = replace(badge.lens, pitch_mm=badge.lens.pitch_mm * (1 + sheet))
    seen = [np.ptp(brightness(lens, lines, 1000 * look_m(badge))) for lines in bands]
    still = ERRORS.index(sheet)
    assert len(seen) == 5 and seen[still] < 0.25 and min(seen[:still] + seen[still + 1 :]) > 0.8


def test_bands_on_either_side_of_the_sheets_own_run_opposite_ways(badge: Badge, bands: list[np.ndarray]) -> None:
    """Catches: a sheet that is read from the wrong end of the bands."""

    def moved_rad(lines: np.ndarray) -> float:
        seen = [np.fft.rfft(brightness(badge.lens, lines, 1000.0, aside_mm) - 0.5) for aside_mm in (0.0, 20.0)]
        return float(np.angle(seen[1] * seen[0].conj())[np.abs(seen[0]).argmax()])

    # Where the phase at a place falls, fringes run to the right.
    assert [moved_rad(bands[k]) < 0 for k in (0, 1, 3, 4)] == [False, False, True, True]


@pytest.mark.parametrize("size_mm", [(85.6, 54.0), (180.0, 230.0), (180.0, 267.0)])
def test_bands_are_off_the_board(size_mm: tuple[float, float], tmp_path: Path) -> None:
    """Catches: bands on the board, or left out where a board leaves no room above it."""
    made = design(size_mm)
    write_badge_pdf(made, tmp_path / "badge.pdf")
    alone = size_mm[1] > 250
    found = geometry(tmp_path / "badge.pdf", int(alone)).fills
    lines = np.array([rect for rect, _ in found if alone or rect[3] < made.outline_mm[1]])
    assert len(np.unique(lines[:, 1])) == 5


@pytest.mark.parametrize("look", [GOOD, MIRRORED])
def test_the_sheet_says_which_way_bands_run(badge: Badge, look: dict[str, float]) -> None:
    """Catches: an arrow for a badge that moves instead of the head, and one way for all looks."""
    first, moved = (
        np.fft.rfft(np.asarray(fringe_pictures(badge, [aside_mm], **look)[0], float)[:4].mean(axis=0) - 139)
        for aside_mm in (0.0, 20.0)
    )
    phase = np.angle(moved * first.conj())[np.abs(first).argmax()]
    assert bool(phase < 0) == runs_right(badge, look.get("beats", 1.0)) == (look is MIRRORED)
