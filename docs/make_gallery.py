"""Make the pictures of README and guides again, `make gallery`: badges, films and verdicts by the commands, the law by
the library.

What comes out is kept with the project, small enough for that.  Badges are those of `gallery.md`: a command
and below it `gallery/NAME.png`.  Each has a given identity, so that its picture stays the same.
"""

from __future__ import annotations

import base64
import io
import math
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import av
import numpy as np
from photograph import photograph
from PIL import Image, ImageDraw, ImageFont

from moireid.badge import load_badge
from moireid.lenticule import trace_mm, view_law
from moireid.optics import parallax_slope_rad, slab_shift_mm
from moireid.profiles import lens_named

DOCS = Path(__file__).parent
OUT = DOCS / "gallery"
FILMS = "tests/data/films"
INK, RAYS = "#1f2a37", ("#0f766e", "#b45309", "#7c3aed")
#: In `gallery.md`: a badge's command without the program, and the name of its picture.
PRINTED = re.compile(r"`print-your-badge ([^`]+)`\n\n!.+\(gallery/(\w+)\.png\)")
VERDICTS = ("genuine_1.0m", "forged_drift_1.0m", "forged_gain_low_1.0m", "forged_reversed_1.0m")
MOVING = {"film": "", "fake": " --forge gain_low"}
#: The two films of `make demo`: names, titles, and how they are forged.
SHOWN = {"true": ("True badge", ""), "forged": ("Forged: a still picture of the badge", " --forge frozen")}
#: Badges to wear, one a template: options in addition to the logo and the portrait.
WORN = {
    "plain": '"Grace Hopper" --payload cdbbf82898d52ed1 --line Guest',
    "conference": '"Ada Lovelace" --payload 7097c67b0fafc59b --line "Keynote" --line "Analytical Engines Ltd"',
    "newsroom": '"Nellie Bly" --payload 5d171902d4d237dc --line "Reporter · Example News" --line "until 31 Dec 2026"',
    "court": '"Amal Example" --payload 0f38c1a2b3d4e5f6 --line "Interpreter" --line "District Court 4"',
    "webcam": '"Emmy Noether" --payload f002052e53c33d71 --line "Example University"',
    "banner": '"Chien-Shiung Wu" --payload 84d1f06b92c37ae5 --line "Speaker"',
    "campus": '"Υπατία" --payload 3a91c05e77d2b846 --line "Φυσική" --line "Example University"',
    "minimal": '"ابن الهيثم" --payload 2b7e151628aed2a6 --line "مهندس"',
}
#: Those that show a portrait.
WITH_PORTRAIT = ("newsroom", "plain", "campus")
#: The logo that they wear.
LOGO = (
    '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 216 60"><circle cx="30" cy="30" r="27" fill="#0f766e"/>'
    '<path d="M14 30h32M20 18h20M20 42h20" stroke="#fff" stroke-width="6"/><path d="M74 12h12l16 25V12h10v36h-11'
    "L84 22v26H74zM124 12h28v9h-18v5h15v9h-15v4h18v9h-28zM160 12h11l6 22 7-22h9l7 22 6-22h10l-11 36h-10l-7-21-7 21"
    'h-10z" fill="#1f2a37"/></svg>'
)
#: Where a badge is filmed, and how it is built there; a moment of each film, its width and height on the page, px.
SCENES = {"worn": "usual:3", "lectern": "typical:3", "call": "typical:3", "desk": "typical:3"}
MOMENT, SCENE_PX = 20, (640, 360)
#: Where the studio's form has a small picture of each template, and its longer side, px.
STYLES, STYLE_PX = DOCS.parent / "studio" / "src" / "moireid_studio" / "static", 300
#: Pixels of the window that a report's page is shown in; all of the page is shown.
PAGE = {"width": 960, "height": 800}


def main() -> None:
    """Write all pictures."""
    with tempfile.TemporaryDirectory() as folder:
        work = Path(folder)
        for wish, name in PRINTED.findall((DOCS / "gallery.md").read_text(encoding="utf-8")):
            _badge(work, name, wish)
        _moving(work)
        for name in VERDICTS:
            _verdict(work, name)
        _side_by_side(work)
        _report(work)
        _worn(work)
        _scenes(work)
        _photograph(work)
    _rays()
    _law()
    _travel()


def _run(command: str, *, codes: tuple[int, ...] = (0,)) -> None:
    """A command of ours.  Raises: SystemExit if it ends with another exit code."""
    program, *arguments = shlex.split(command)
    start = "print_your_badge" if program == "print-your-badge" else "main"
    code = f"from moireid.cli.main import {start} as start; start()"
    done = subprocess.run([sys.executable, "-c", code, *arguments], capture_output=True, text=True, check=False)
    if done.returncode not in codes:
        raise SystemExit(f"{command}: {done.stderr}")


def _badge(work: Path, name: str, wish: str) -> None:
    _run(f"print-your-badge {wish} --out {work / name} --mount none")
    with Image.open(work / name / "preview.png") as picture:
        small = picture.convert("L").resize(
            (420, round(420 * picture.height / picture.width)), Image.Resampling.LANCZOS
        )
    small.quantize(12).save(OUT / f"{name}.png", optimize=True)


def _worn(work: Path) -> None:
    """A badge in each template side by side."""
    (work / "logo.svg").write_text(LOGO, encoding="utf-8")
    _face().save(work / "face.png")
    shown = []
    for template, wish in WORN.items():
        size = "--format webcam" if template == "webcam" else "--format a6 --orientation portrait"
        portrait = f"--portrait {work / 'face.png'}" if template in WITH_PORTRAIT else ""
        out = work / f"worn-{template}"
        _run(
            f"print-your-badge {wish} {size} --template {template} --logo {work / 'logo.svg'} {portrait} --out {out} "
            "--mount none"
        )
        with Image.open(out / "preview.png") as picture:
            width = round(330 * picture.width / picture.height)
            shown.append(picture.convert("RGB").resize((width, 330), Image.Resampling.LANCZOS))
            small = picture.convert("RGB")
            small.thumbnail((STYLE_PX, STYLE_PX), Image.Resampling.LANCZOS)
            small.save(STYLES / f"style-{template}.webp", quality=70, method=6)
    rows = [shown[:4], shown[4:]]
    wide = max(sum(one.width + 14 for one in row) - 14 for row in rows)
    sheet = Image.new("RGB", (wide, 330 * len(rows) + 14), "white")
    for number, row in enumerate(rows):
        for k, one in enumerate(row):
            sheet.paste(one, (sum(before.width + 14 for before in row[:k]), number * 344))
    sheet.quantize(128).save(OUT / "templates.png", optimize=True)


def _face() -> Image.Image:
    """A drawn figure in place of a portrait, which would show a person."""
    picture = Image.new("RGB", (232, 290), "#dbe4ea")
    draw = ImageDraw.Draw(picture)
    draw.ellipse((16, 190, 216, 400), fill="#22577a")
    draw.ellipse((66, 60, 166, 190), fill="#c98f6b")
    draw.chord((60, 44, 172, 170), 180, 360, fill="#3b2a20")
    return picture


def _labelled(picture: Image.Image, share: int = 45) -> Image.Image:
    """The picture with the word "simulated" in its lower right corner, so many times smaller than it is wide."""
    made = picture.convert("RGB")
    font, draw = ImageFont.load_default(max(11, made.width // share)), ImageDraw.Draw(made)
    left, top, right, bottom = draw.textbbox((made.width - 6, made.height - 6), "simulated", font, "rb")
    draw.rectangle((left - 4, top - 3, right + 4, bottom + 4), fill="white")
    draw.text((made.width - 6, made.height - 6), "simulated", "#1f2a37", font, "rb")
    return made


def _photograph(work: Path) -> None:
    """The badge of a speaker as it is worn, path-traced: some minutes of work."""
    made = photograph(work / "worn-conference" / "badge.json", rays=512)
    # README shows it small.
    _labelled(made, 20).save(OUT / "photograph.webp", quality=80, method=6)


def _scenes(work: Path) -> None:
    """A moment of a film in each scene, in two rows."""
    import cv2

    wish = f"--frames {2 * MOMENT} --fps 30 --motion sway --distance 0.8 --overwrite"
    shown = Image.new("RGB", (2 * SCENE_PX[0] + 8, 2 * SCENE_PX[1] + 8), "white")
    for number, (scene, build) in enumerate(SCENES.items()):
        film = work / f"{scene}.mp4"
        badge_json = work / "worn-conference" / "badge.json"
        _run(f"moireid simulate {badge_json} --out {film} --scene {scene} --build {build} {wish}")
        reader = cv2.VideoCapture(str(film))
        for _ in range(MOMENT):
            _, picture = reader.read()
        small = Image.fromarray(picture[..., ::-1]).resize(SCENE_PX, Image.Resampling.LANCZOS)
        shown.paste(small, (number % 2 * (SCENE_PX[0] + 8), number // 2 * (SCENE_PX[1] + 8)))
    _labelled(shown).save(OUT / "scenes.webp", quality=72, method=6)


def _moving(work: Path) -> None:
    """A true and a forged film of the same motion side by side, as one moving picture."""
    shown = []
    for name, forge in MOVING.items():
        film = work / f"{name}.mp4"
        _run(
            f"moireid simulate {work / 'ada' / 'badge.json'} --out {film} --scene worn --camera webcam --motion sway "
            f"--distance 1 --frames 75 --fps 30{forge}"
        )
        with av.open(str(film)) as opened:
            frames = [frame.to_image() for frame in opened.decode(video=0)][::3]
        shown.append(
            [frame.crop((491, 200, 821, 530)).resize((320, 320), Image.Resampling.LANCZOS) for frame in frames]
        )
    pictures = [
        _labelled(Image.fromarray(np.hstack([np.asarray(true), np.asarray(fake)])))
        for true, fake in zip(*shown, strict=True)
    ]
    # There and back, so that it goes on without a jump.
    pictures += pictures[-2:0:-1]
    pictures[0].save(
        OUT / "moving.webp", save_all=True, append_images=pictures[1:], duration=100, loop=0, quality=25, method=6
    )


def _verdict(work: Path, name: str) -> None:
    _run(f"moireid verify {FILMS}/{name}.mp4 --badge {FILMS}/badge.json --report {work / name}", codes=(0, 1, 3))
    page = (work / name / "report.html").read_text(encoding="utf-8")
    found = re.search(r'<img class="plot" src="data:image/svg\+xml;base64,([^"]+)"', page)
    if found is None:
        raise SystemExit(f"the report on {name} has no plot")
    _write_svg(f"{name}.svg", _by_day(base64.b64decode(found[1]).decode()))


def _by_day(svg: str) -> str:
    """A report's plot on white, as the guides' light and dark are not the system's."""
    svg = re.sub(r"@media[^{]*\{svg\{[^}]*\}\}", "", svg)
    return svg.replace("</style>", '</style><rect width="100%" height="100%" fill="#fff"/>', 1)


def _side_by_side(work: Path) -> None:
    """The still of the demo's two films, verified."""
    badge, words = work / "ada" / "badge.json", []
    for name, (title, forge) in SHOWN.items():
        film = f"{work / name}.mp4"
        wish = f"--scene worn --camera webcam --motion circle --distance 0.6 --frames 150 --fps 30{forge}"
        _run(f"moireid simulate {badge} --out {film} {wish}")
        _run(f"moireid verify {film} --badge {badge} --report {work / name}", codes=(0, 1))
        words += [title, film, str(work / name)]
    subprocess.run([sys.executable, "examples/side_by_side.py", str(work / "both.mp4"), *words], check=True)
    with Image.open(work / "both.png") as still:
        _labelled(still).save(OUT / "true_and_forged.webp", quality=80, method=6)


def _report(work: Path) -> None:
    """The report on the true film, as a browser shows it."""
    from playwright.sync_api import sync_playwright

    chromium = shutil.which("chromium")
    if chromium is None:
        raise SystemExit("the picture of a report needs Chromium; install the Debian package chromium")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        page = browser.new_page(viewport=PAGE)
        page.goto((work / "true" / "report.html").as_uri())
        shot = page.screenshot(full_page=True)
        browser.close()
    with Image.open(io.BytesIO(shot)) as picture:
        _labelled(picture).save(DOCS / "report.webp", quality=50, method=6)


def _rays() -> None:
    """Where rays land that come through three lenses from three directions."""
    lens = lens_named("50lpi")
    figure, axes = _figure(6.4, 3.0)
    assert lens.radius_mm is not None
    x = np.linspace(-2.5, 2.5, 1001) * lens.pitch_mm
    offset = x - np.round(x / lens.pitch_mm) * lens.pitch_mm
    surface = lens.radius_mm - np.sqrt(lens.radius_mm**2 - offset**2)
    axes.fill_between(x, -surface, -lens.thickness_mm, color="#dbeafe", linewidth=0)
    for degrees, colour in zip((-20, 0, 20), RAYS, strict=True):
        tangent = math.tan(math.radians(degrees))
        start = np.linspace(-0.4, 0.4, 7) * lens.pitch_mm
        landed = trace_mm(lens, start, np.full(7, tangent), np.zeros(7))[0]
        for begin, end in zip(start, landed, strict=True):
            axes.plot([begin - 0.6 * tangent, begin], [0.6, 0], color=colour, linewidth=0.8)
            axes.plot([begin, end], [0, -lens.thickness_mm], color=colour, linewidth=0.8)
    for k in range(-3, 4):
        axes.plot([k * 0.52 - 0.13, k * 0.52 + 0.13], [-1.02, -1.02], color=INK, linewidth=5, solid_capstyle="butt")
    axes.set_aspect("equal")
    axes.set_xlim(-1.27, 1.27)
    axes.set_ylim(-1.1, 0.55)
    axes.set_xlabel("mm; lenses above, printed lines below")
    axes.set_yticks([])
    axes.spines["left"].set_visible(False)
    _save(figure, "rays.svg")


def _law() -> None:
    """The phase that a turn of the view adds: traced, straight, and of a flat slab."""
    lens, pitch_mm = lens_named("50lpi"), 0.52
    law = view_law(lens, pitch_mm)
    degrees = np.linspace(-60, 60, 121)
    tangents = np.tan(np.radians(degrees))
    figure, axes = _figure(6.4, 3.2)
    straight = parallax_slope_rad(law.effective_gap_mm(pitch_mm), pitch_mm) * tangents
    slab = 2 * math.pi / pitch_mm * slab_shift_mm(lens.thickness_mm, lens.refractive_index, tangents)
    turns = 2 * math.pi
    axes.plot(degrees, straight / turns, color=RAYS[1], linewidth=1, linestyle="--", label="the straight law")
    axes.plot(degrees, slab / turns, color=RAYS[2], linewidth=1, linestyle=":", label="a flat slab")
    axes.plot(degrees, law.phase_rad(tangents) / turns, color=RAYS[0], linewidth=2, label="traced through the lens")
    axes.set_xlabel("view angle, degrees")
    axes.set_ylabel("fringes travel by, turns")
    axes.legend(frameon=False, fontsize=9)
    _save(figure, "law.svg")


def _travel() -> None:
    """Fringes of the published board's row from camera places 10 cm apart, 1 m away."""
    badge = load_badge(Path(FILMS) / "badge.json")
    grating, lens = badge.gratings[0], badge.lens
    cell, law = grating.cells[0], view_law(lens, grating.cells[0].pitch_mm)
    x = np.linspace(cell.rect_mm[0], cell.rect_mm[2], 640)
    middle = (x[0] + x[-1]) / 2
    rows = []
    for camera_mm in np.arange(-250, 251, 100):
        # The phase that a lens shows: where it lies over the lines, and what the view adds.
        phase = 2 * math.pi * x * (1 / cell.pitch_mm - 1 / lens.pitch_mm)
        phase = phase + law.phase_rad((x - middle - camera_mm) / 1000.0)
        rows += [
            np.repeat((140 + 95 * np.cos(phase))[None].astype(np.uint8), 34, axis=0),
            np.full((4, 640), 255, np.uint8),
        ]
    _labelled(Image.fromarray(np.vstack(rows[:-1]))).quantize(64).save(OUT / "travel.png", optimize=True)


def _figure(width: float, height: float) -> tuple[Any, Any]:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    axes = figure.add_subplot()
    axes.spines[["top", "right"]].set_visible(False)
    axes.tick_params(colors=INK, labelsize=9)
    return figure, axes


def _save(figure: Any, name: str) -> None:
    from matplotlib import rc_context

    out = io.StringIO()
    with rc_context({"svg.fonttype": "none", "svg.hashsalt": "moireid", "font.family": "sans-serif"}):
        figure.savefig(out, format="svg", metadata={"Date": None})
    _write_svg(name, out.getvalue()[out.getvalue().index("<svg") :])


def _write_svg(name: str, text: str) -> None:
    """With figures of two digits, as none of these pictures is looked at closer."""
    text = re.sub(r"(\d+\.\d{2})\d+", r"\1", text)
    if "xmlns=" not in text[:400]:
        text = text.replace("<svg", '<svg xmlns="http://www.w3.org/2000/svg"', 1)
    (OUT / name).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
