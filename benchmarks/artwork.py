"""Does artwork change what is read?  Run `moireid lab bench artwork [--only cr80]`.

It needs pdftoppm (poppler).

Each badge's page is printed twice, with all that its template can wear and with markers and lines alone.  Poppler
rasterises both, the simulator films both rasters on the same course, and the verifier reads both films.

Printed is, for each template and format: how many dots differ at 600 dpi where nothing may (0 is asked); by how much
the fringe phase of any strip of the badge is off over the film (0.002 rad is asked), and of a frame (root mean square);
and which identities are read.  Films are coded without loss: a codec spends its bits elsewhere where there is more to
see, which is no matter of what is printed.
"""

from __future__ import annotations

import subprocess
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from unittest.mock import patch

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from moireid.artwork.clear import clear_zones
from moireid.artwork.content import content_of, with_lines
from moireid.artwork.placing import Look
from moireid.artwork.template import TEMPLATES, template_named
from moireid.badge import Badge
from moireid.designer import Order, design_badge
from moireid.designer.formats import FORMATS, turned
from moireid.fabrication.page.canvas import PdfPage
from moireid.fabrication.page.pdf import write_badge_pdf
from moireid.simulate import Build, Scene, camera_named, film, motion_named
from moireid.simulate.analytic import analytic_renderer
from moireid.simulate.analytic.traced_page import TEXTURE_PX_PER_MM
from moireid.verifier import Claim, verify
from moireid.verifier.fringes.signals import measure
from moireid.verifier.tracking.track import Track
from moireid_lab.bench.bench_frame import Bench, Row, Wish

PAYLOAD = bytes.fromhex("0f5ac3962d784be1")
LINES = ("Reporter · Example News", "Accredited until 31 Dec 2026")
DPI, FRAMES, FPS, CRF = 600, 60, 30, 0
Plain = Callable[[PdfPage, Badge], None]


def dressed(template: str, name: str, orientation: str, folder: Path) -> Badge:
    """A badge that wears all its template has places for, with pictures of many edges and squares."""
    form, pictures = FORMATS[name], _pictures(folder)
    look = Look(template_named(template), content_of(*pictures, "#134e8c"), form.corner_mm)
    side = look.template.side(*turned(form.size_mm, orientation))
    order = Order("Ada Lovelace", format=name, orientation=orientation, head=side.head, foot=side.foot)
    return replace(with_lines(design_badge(order, PAYLOAD), LINES), look=look)


def _pictures(folder: Path) -> tuple[Path, Path]:
    """A logo of nested squares, and a portrait that is a chessboard."""
    logo, portrait = folder / "logo.png", folder / "portrait.png"
    picture = Image.new("RGB", (600, 200), "white")
    draw = ImageDraw.Draw(picture)
    for k, colour in enumerate(("black", "#134e8c", "white", "black", "#134e8c")):
        draw.rectangle((20 + 18 * k, 20 + 18 * k, 180 - 18 * k, 180 - 18 * k), fill=colour)
    draw.rectangle((220, 60, 580, 140), outline="black", width=12)
    picture.save(logo)
    board = np.kron(np.indices((10, 8)).sum(axis=0) % 2, np.ones((40, 40)))
    Image.fromarray((255 * board).astype(np.uint8)).save(portrait)
    return logo, portrait


def printed(badge: Badge, folder: Path, *, worn: bool) -> NDArray[np.uint8]:
    """The board as poppler rasterises the page, grey, `DPI`."""
    pdf = folder / "page.pdf"
    bare: Plain = lambda sheet, badge: None  # noqa: E731
    write_badge_pdf(badge, pdf, write_words=None if worn else bare)
    subprocess.run(["pdftoppm", "-r", str(DPI), "-gray", "-singlefile", str(pdf), str(pdf.with_suffix(""))], check=True)
    with Image.open(pdf.with_suffix(".pgm")) as page:
        x0, y0, x1, y1 = (round(side * DPI / 25.4) for side in badge.outline_mm)
        return np.asarray(page.crop((x0, y0, x1, y1)).convert("L"))


def filmed(badge: Badge, board: NDArray[np.uint8], video: Path) -> None:
    """Film a raster of the board under its lens sheet, at the middle of its range."""
    assert badge.range_m is not None
    distance_mm = 500.0 * sum(badge.range_m)
    scene = Scene(badge, Build(), camera_named("ideal"))
    x0, y0, x1, y1 = badge.outline_mm
    size = (int(np.ceil((x1 - x0) * TEXTURE_PX_PER_MM)), int(np.ceil((y1 - y0) * TEXTURE_PX_PER_MM)))
    small = np.asarray(Image.fromarray(board).resize(size, Image.Resampling.BOX), np.float32) / 255
    texture = (scene.ink + (scene.paper - scene.ink) * small).astype(np.float32)
    with patch.object(analytic_renderer, "page_texture", lambda scene: texture):
        course = motion_named("sway", distance_mm=distance_mm, seed=1)
        film(scene, course, video, frames=FRAMES, fps=FPS, seed=1, crf=CRF, overwrite=True)


def compare(template: str, name: str, orientation: str, folder: Path) -> Row:
    """Print, film and read a badge with and without what it wears."""
    badge = dressed(template, name, orientation, folder)
    boards = [printed(badge, folder, worn=worn) for worn in (False, True)]
    read = []
    for k, board in enumerate(boards):
        filmed(badge, board, folder / f"{k}.mp4")
        read.append(verify(folder / f"{k}.mp4", Claim(badge)))
    bare, worn = (_phases(one.track) for one in read)
    both = np.isin(bare[0], worn[0]), np.isin(worn[0], bare[0])
    apart = np.angle(np.exp(1j * (worn[1][:, both[1]] - bare[1][:, both[0]])))
    ids = {one.identity.decoded_id for one in read}
    return {
        "template": template,
        "format": name,
        "orientation": orientation,
        "dots": _dots(badge, *boards),
        "strip rad": float(np.abs(apart.mean(axis=1)).max()),
        "frame rad": float(np.sqrt(np.mean(apart.mean(axis=0) ** 2))),
        "identities": "both read" if ids == {PAYLOAD.hex()} else f"read {ids}",
    }


def _phases(track: Track) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Numbers of the frames, (T,), and the phase of each uniform strip in them, (S, T)."""
    return track.frame_numbers, np.array([strip.phase_rad for strip in measure(track).strips if strip is not None])


def _dots(badge: Badge, bare: NDArray[np.uint8], worn: NDArray[np.uint8]) -> int:
    """How many dots differ where nothing may; a dot at a zone's edge is left out."""
    scale, (left, top, _, _) = DPI / 25.4, badge.outline_mm
    differ = 0
    for _, (x0, y0, x1, y1) in clear_zones(badge):
        rows = slice(max(round((y0 - top) * scale) + 1, 0), round((y1 - top) * scale) - 1)
        columns = slice(max(round((x0 - left) * scale) + 1, 0), round((x1 - left) * scale) - 1)
        differ += int(np.count_nonzero(bare[rows, columns] != worn[rows, columns]))
    return differ


def rows(wish: Wish) -> Iterator[Row]:
    """One row a template and format."""
    kinds = [(template, name) for name in ("cr80", "a6", "board") for template in TEMPLATES]
    wanted = wish.chosen(f"{name} {template}" for template, name in kinds)
    with tempfile.TemporaryDirectory() as folder:
        for k, (template, name) in enumerate(kinds):
            if f"{name} {template}" in wanted:
                yield compare(template, name, ("portrait", "landscape")[k % 2], Path(folder))


COLUMNS = {"template": "<11", "format": "<9", "orientation": "<11", "dots": ">5", "strip rad": ">10.5f"}
BENCH = Bench(rows, COLUMNS | {"frame rad": ">10.5f", "identities": "<1"})
