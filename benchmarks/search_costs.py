"""What looking for a badge and decoding cost: run `.venv/bin/python benchmarks/search_costs.py [--only REGEX]`.

`verifier/tracking/search_work.py` counts the work of a search in nanoseconds of a nominal machine, so that a verdict is
the same on every machine; here these counts are compared with processor time, and its constants are set by it.

Rows "decode": pictures of a drawn room, 1080p with a sensor's noise, coded by several codecs at several qualities;
bytes a picture, and processor time of decoding by one thread, ns a pixel, the least of some runs.  `DECODED_NS` is that
of a low bit rate, where decoding costs least: then no film's searches cost more than their share.
Rows "look": each search of a picture, its processor ms, over the nominal work that it counts, and over decoding a
picture by `DECODED_NS`: in the room, in noise, before an even wall.
Rows "step": drawing, smearing and registering a template of a page in view, its solver apart, and following a page as
if it were smeared, over the same; by the width of a marker, px.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from functools import cache, partial
from pathlib import Path

import av
import numpy as np
from numpy.typing import NDArray
from speed_films import BADGE, Room
from tracking import HeldBadge, as_coded, held

from moireid.simulate.cameras import Camera
from moireid.verifier.picture import Picture
from moireid.verifier.tracking.finding.markers import MarkerFinder, tiles_of
from moireid.verifier.tracking.print_template import Template
from moireid.verifier.tracking.registration import KeptTemplate, PageRegistrar, scale_px_per_mm
from moireid.verifier.tracking.search_work import DECODED_NS
from moireid.verifier.tracking.smeared_frames import ShakenFollower
from moireid.verifier.tracking.track import FrameSighting, TrackEnds
from moireid.verifier.video import Film
from moireid_lab.bench.bench_frame import Bench, Row, Wish, run_script

Counts = NDArray[np.uint8]
CAMERA, FRAMES, RUNS = Camera(), 40, 5
MARKERS_PX, STEPS = (25, 50, 100), ("draw", "smear", "solve and register", "register", "follow as smeared")
#: Codec, and its options by quality: as a call, a phone and an editor code films.
CODECS = {
    "H.264": ("libx264", ({"crf": "34"}, {"crf": "28"}, {"crf": "23"}, {"crf": "18"})),
    "HEVC": (
        "libx265",
        ({"crf": "34", "x265-params": "log-level=none"}, {"crf": "23", "x265-params": "log-level=none"}),
    ),
    "VP9": ("libvpx-vp9", ({"crf": "40", "b": "0", "cpu-used": "6"}, {"crf": "25", "b": "0", "cpu-used": "6"})),
}


def room_pictures(count: int) -> Iterator[Counts]:
    """A camera that is carried slowly through the room."""
    room, empty = Room(CAMERA), np.zeros((CAMERA.height, CAMERA.width), np.uint8)
    for number in range(count):
        way = np.eye(3)
        way[:2, 2] = 700 + 3.0 * number, 400 + 1.0 * number
        yield room.alone(number, empty, way)


def least_s(work: Callable[[], object], runs: int = RUNS) -> float:
    """Processor seconds of this thread, the least of some runs."""
    spent = []
    for _ in range(runs):
        begun = time.thread_time()
        work()
        spent.append(time.thread_time() - begun)
    return min(spent)


def coded(path: Path, codec: str, options: dict[str, str]) -> Path:
    """A film of the room."""
    with av.open(str(path), "w") as container:
        stream = container.add_stream(codec, rate=30, options=options)
        stream.width, stream.height, stream.pix_fmt = CAMERA.width, CAMERA.height, "yuv420p"
        for picture in room_pictures(FRAMES):
            container.mux(stream.encode(av.VideoFrame.from_ndarray(picture, format="gray")))
        container.mux(stream.encode())
    return path


def decode_row(folder: Path, codec: str, options: dict[str, str]) -> Row:
    """Cost of decoding a film of the room."""
    path = folder / f"{codec}_{options['crf']}.mp4"
    if not path.exists():
        coded(path, codec, options)
    seconds = least_s(lambda: sum(1 for _ in Film(path).frames()))
    pixels = FRAMES * CAMERA.width * CAMERA.height
    return {"kB": path.stat().st_size / FRAMES / 1e3, "ns a pixel": 1e9 * seconds / pixels}


def look_row(finder: MarkerFinder, picture: Counts, look: Callable[[Picture], object]) -> Row:
    """Cost of one search of a picture, which is coded as video is."""
    before = finder.work_ns
    look(as_coded(picture))
    nominal_s = 1e-9 * (finder.work_ns - before)
    # A picture keeps its counts once they are made, so each run has its own.
    several = [as_coded(picture) for _ in range(RUNS)]
    real_s = least_s(lambda: look(several.pop()))
    decoding_s = 1e-9 * DECODED_NS * picture.size
    return {"ms": 1e3 * real_s, "over nominal": real_s / nominal_s, "over decoding": real_s / decoding_s}


@cache
def page_in_view(marker_px: int) -> HeldBadge:
    """A film of a badge in a hand, with markers of about that width."""
    return held(26 * CAMERA.focal_px / marker_px)


def step_row(step: str, marker_px: int) -> Row:
    """Cost of one step of following a page, in the middle of a film; a step's own preparation is not timed."""
    film = page_in_view(marker_px)
    middle = len(film.frames) // 2
    picture, page, time_s = film.frames[middle].picture, film.homographies[middle], film.frames[middle].time_s
    registrar = PageRegistrar(film.badge.markers)
    printer, kept = registrar.printer, KeptTemplate(registrar.printer)
    px_per_mm, template = scale_px_per_mm(page, printer.middle), kept.at(page)
    smear_mm = np.tile([printer.module_mm, 0.0], (len(printer.patches), 1))
    before, last = (FrameSighting(at, film.frames[at].time_s, film.homographies[at]) for at in (middle - 2, middle - 1))
    follower = ShakenFollower(registrar, kept, TrackEnds(before=before, last=last))
    works: dict[str, tuple[Callable[[], Template | None], Callable[[Template | None], object]]] = {
        "draw": (lambda: None, lambda _: printer.draw(px_per_mm)),
        "smear": (lambda: None, lambda _: printer.smeared(template, smear_mm)),
        "solve and register": (
            partial(printer.draw, px_per_mm),
            lambda fresh: registrar.register(picture, page, fresh),
        ),
        "register": (lambda: template, lambda sharp: registrar.register(picture, page, sharp)),
        "follow as smeared": (lambda: None, lambda _: follower.find(picture, time_s)),
    }
    prepare, work = works[step]
    work(prepare())
    real_s, nominal_s = math.inf, 0.0
    for _ in range(4 * RUNS):
        given = prepare()
        counted, begun = registrar.work_ns + printer.work_ns, time.thread_time()
        work(given)
        real_s = min(real_s, time.thread_time() - begun)
        nominal_s = 1e-9 * (registrar.work_ns + printer.work_ns - counted)
    decoding_s = 1e-9 * DECODED_NS * CAMERA.width * CAMERA.height
    return {"ms": 1e3 * real_s, "over nominal": real_s / nominal_s, "over decoding": real_s / decoding_s}


def rows(wish: Wish) -> Iterator[Row]:
    """One row a case."""
    finder, rng = MarkerFinder(BADGE.markers), np.random.default_rng(wish.seed)
    size = (CAMERA.height, CAMERA.width)
    noise, wall = rng.normal(128, 40, size).clip(0, 255), rng.normal(128, CAMERA.noise_counts, size)
    pictures = {"room": next(room_pictures(1)), "noise": noise.astype(np.uint8), "wall": wall.astype(np.uint8)}
    looks: dict[str, Callable[[Picture], object]] = {
        "close": finder.either_way,
        "close, faded print": partial(finder.either_way, faint=True),
        "quick": finder.quick,
        "tile": partial(finder.enlarged, box=tiles_of(size)[0]),
    }
    with wish.kept_folder() as folder:
        cases: dict[str, Callable[[], Row]] = {
            f"decode {name}, crf {options['crf']}": partial(decode_row, folder, codec, options)
            for name, (codec, several) in CODECS.items()
            for options in several
        }
        for place, picture in pictures.items():
            cases |= {f"look {name}, {place}": partial(look_row, finder, picture, look) for name, look in looks.items()}
        cases |= {f"step {step}, {px} px": partial(step_row, step, px) for px in MARKERS_PX for step in STEPS}
        for name in wish.chosen(cases):
            yield {"case": name} | cases[name]()


COLUMNS = {"case": "<32", "kB": ">7.1f", "ns a pixel": ">10.2f", "ms": ">7.2f", "over nominal": ">12.2f"}
COLUMNS |= {"over decoding": ">13.2f"}
BENCH = Bench(rows, COLUMNS)

if __name__ == "__main__":
    run_script(__file__)
