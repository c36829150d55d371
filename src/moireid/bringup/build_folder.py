"""The folder of a first badge: what is wished, which pictures and films are there, and what was read of them.

A builder puts files of well-known names into the folder.  Whatever was read is kept with the digests of its inputs, so
that nothing is read twice, and a new film is read at once.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

import msgspec
from msgspec import Meta, Struct

from moireid.errors import SpecError
from moireid.files import open_regular, planned, read_regular, write_text
from moireid.models import check_format, parse_json, read_model
from moireid.profiles import lens_named
from moireid.sheets import DEFAULT_LENS

FORMAT, STATE = 1, "first-badge.json"
#: Files that a builder makes, by their names without suffix.
SHEET_PHOTO = "sheet-photo"
BADGE_FILMS = ("badge-film-1", "badge-film-2")
PHOTO_SUFFIXES = (".jpg", ".jpeg", ".png", ".webp", ".tif", ".tiff")
FILM_SUFFIXES = (".mp4", ".mov", ".m4v", ".mkv", ".webm", ".avi")
#: Phones write these, and the project cannot read them.
UNREADABLE = (".heic", ".heif")
SUFFIXES = PHOTO_SUFFIXES + FILM_SUFFIXES + UNREADABLE
#: What is written into the folder, and replaced as better pictures come.
OWN_FILES = (*("pitch-test.pdf", "pitch-test.json", "sheet.json", "printer.json", "badge", "as-built.json"),)
BADGE_JSON = "badge/badge.json"
#: A camera that the builder calibrated, if so.
CAMERA = "camera.yaml"
ADVICE = "give another folder, or correct the file"


class Figure(Struct, frozen=True, omit_defaults=True):
    """One figure of a badge as it was built.

    value: None if it was not measured; sd: standard deviation, in the same unit; words: how it was measured, or why it
    was not; advice: what to do about it, empty where it is good.
    """

    name: str
    value: float | None
    sd: float | None
    unit: str
    words: str
    advice: str = ""

    @property
    def shown(self) -> str:
        """The value with its error bar, rounded to two digits of it."""
        if self.value is None:
            return "not known"
        if not self.sd:
            return f"{self.value:.3g} {self.unit}"
        digits = max(0, 1 - math.floor(math.log10(self.sd)))
        return f"{self.value:.{digits}f} ± {self.sd:.{digits}f} {self.unit}"


class Reading(Struct, frozen=True):
    """What one step found.  inputs: as `BuildFolder.inputs`; refused: why files could not be used, None if they could.

    notes: for the builder alone; figures are shared, so they hold no path.
    """

    inputs: dict[str, str] = {}
    figures: list[Figure] = []
    notes: list[str] = []
    refused: str | None = None


class Wish(Struct, frozen=True):
    """What the builder wants, and measured by hand.

    printer: the name under which the measured printer is kept, None for none; thickness_mm: of the sheet by a calliper;
    measured_scale: measured over stated length of the chart's scale bars;
    distance_m, focal_px: of the photo of the pitch test.
    """

    name: str = "First Badge"
    lens: str = DEFAULT_LENS
    printer: str | None = None
    printer_dpi: int = 1200
    paper: Literal["a4", "letter"] = "a4"
    thickness_mm: Annotated[float, Meta(gt=0)] | None = None
    measured_scale: tuple[float, float] | None = None
    distance_m: Annotated[float, Meta(gt=0)] | None = None
    focal_px: Annotated[float, Meta(gt=0)] | None = None


class BuildState(Struct, frozen=True):
    """The state of a folder; readings: what was found, by step."""

    format: Literal[1] = 1
    kind: Literal["first-badge"] = "first-badge"
    wish: Wish = Wish()
    readings: dict[str, Reading] = {}


#: What the pitch test is printed for, and what the builder measures of it by hand.
PRINTED_FOR = ("lens", "printer_dpi", "paper")
BY_HAND = ("thickness_mm", "measured_scale", "distance_m", "focal_px")


class BuildFolder:
    """A folder, what the builder wants, and what was found so far, by step."""

    def __init__(self, path: Path, wish: Wish, readings: Mapping[str, Reading]) -> None:
        self.path, self.wish, self.readings = path, wish, dict(readings)

    def at(self, name: str) -> Path:
        """The path of a file that moireid writes."""
        return self.path / name

    def found(self, name: str) -> Path | None:
        """A photograph or film by its well-known name; None where there is none.

        Raises: SpecError where there are several here, or one in a format that cannot be read.
        """
        there = sorted(one for one in self.path.glob(f"{name}.*") if one.suffix.lower() in SUFFIXES and one.is_file())
        if len(there) > 1:
            names = " and ".join(path.name for path in there)
            raise SpecError(f"{self.path} has {names}; keep one of them, as both are {name}")
        if there and there[0].suffix.lower() in UNREADABLE:
            raise SpecError(f"{there[0]} is in a format that moireid does not read; export it as JPEG")
        return there[0] if there else None

    def inputs(self, media: Iterable[str], own: Iterable[str], wishes: Iterable[str]) -> dict[str, str]:
        """What a step depends on: digests of the files that are there, by their names here, and wishes as text.

        Parameters: media: well-known names of photographs and films; own: files that moireid wrote; wishes: fields.
        """
        files = {name: self.found(name) for name in media} | {name: self.at(name) for name in own}
        digests = {name: _digest(path) for name, path in files.items() if path is not None and path.exists()}
        return digests | {key: str(getattr(self.wish, key)) for key in wishes}

    def figures(self) -> list[Figure]:
        """All figures, in the order in which the steps were first done."""
        return [figure for reading in self.readings.values() for figure in reading.figures]

    def save(self) -> None:
        """Write the state, whole or not at all."""
        state = msgspec.json.encode(BuildState(wish=self.wish, readings=self.readings))
        write_text(self.at(STATE), msgspec.json.format(state, indent=1).decode() + "\n")


def open_folder(path: Path, wished: Mapping[str, Any] | None = None) -> BuildFolder:
    """The folder, made where it does not exist, with what is wished now.

    Parameters
    ----------
    path : Path
        The folder.
    wished : mapping of str, optional
        Fields of `Wish` that are given now, in their units; 0 for one that is forgotten, None for others.

    Raises
    ------
    SpecError
        Where the folder holds files that would be replaced, was begun for another sheet, printer or paper, has the
        badge of another name, or cannot be written; and for a sheet that is not known.
    """
    if not (path / STATE).exists() and (taken := [name for name in OWN_FILES if (path / name).exists()]):
        raise SpecError(
            f"{path / taken[0]} exists already, and {path} was not begun by moireid first-badge; give a new folder"
        )
    state = _state_in(path)
    given = {key: value or None for key, value in (wished or {}).items() if value is not None}
    wish = msgspec.structs.replace(state.wish, **given)
    # A sheet that is not known is refused before anything is made for it.
    lens_named(wish.lens)
    _check_printed(path, state, wish)
    planned([path / STATE], overwrite=True)
    return BuildFolder(path, wish, state.readings)


def _check_printed(path: Path, state: BuildState, wish: Wish) -> None:
    """Raise SpecError where something is printed already, and for something else than is wished now."""
    charts = any(reading.refused is None for reading in state.readings.values())
    kept = PRINTED_FOR * charts + ("name",) * (path / BADGE_JSON).exists()
    for key in kept:
        printed, wished = getattr(state.wish, key), getattr(wish, key)
        if printed != wished:
            raise SpecError(
                f"{path} was begun with {key}={printed}, and {wished} is given; give another folder for another name, "
                "sheet, printer or paper"
            )


def _state_in(path: Path) -> BuildState:
    """The state of a folder; an empty one for a folder without."""
    file = path / STATE
    if not file.exists():
        return BuildState()
    source = str(file)
    try:
        text = read_regular(file).decode("utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise SpecError(f"{source} cannot be read; {ADVICE}") from error
    document = parse_json(text, source, ADVICE)
    check_format(document, FORMAT, source)
    return read_model(document, BuildState, source, ADVICE)


def _digest(path: Path) -> str:
    with open_regular(path) as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
