"""The folder of a first badge: what is wished, which pictures and films are there, and what was read of them.

A builder puts files of well-known names into the folder, or names others by an option.  Whatever was read is kept with
the digests of its inputs, so that nothing is read twice, and a new film is read at once.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import msgspec
from msgspec import Meta, Struct

from moireid.errors import SpecError
from moireid.files import write_text
from moireid.models import check_format, parse_json, read_model
from moireid.profiles import lens_named

FORMAT, STATE = 1, "first-badge.json"
#: Files that a builder makes, by their names without suffix.
SHEET_PHOTO, SHEET_FILM, CAMERA_FILM = "sheet-photo", "sheet-film", "camera-film"
BADGE_FILMS = ("badge-film-1", "badge-film-2")
PHOTO_SUFFIXES = (".jpg", ".jpeg", ".png", ".webp", ".tif", ".tiff")
FILM_SUFFIXES = (".mp4", ".mov", ".m4v", ".mkv", ".webm", ".avi")
#: Phones write these, and the project cannot read them.
UNREADABLE = (".heic", ".heif")
#: What is written into the folder, and replaced as better pictures come.
OWN_FILES = (
    *("pitch-test.pdf", "pitch-test.json", "camera-chart.pdf", "sheet.json", "printer.json", "camera.yaml", "badge"),
    *("films.json", "as-built.json", "report.html"),
)
ADVICE = "give another folder, or correct the file"

State = Literal["good", "look", "unknown"]


class Figure(Struct, frozen=True):
    """One figure of a badge as it was built.

    sd: standard deviation, in the same unit; state: good, to be looked at, or unknown; words: how it was measured, or
    why it is unknown; advice: what to do about it.
    """

    name: str
    value: float | None
    sd: float | None
    unit: str
    state: State
    words: str
    advice: str = ""


def good_or(good: bool) -> State:
    """The state of a figure that was measured."""
    return "good" if good else "look"


def unknown(name: str, unit: str, words: str, advice: str) -> Figure:
    """A figure that was not measured."""
    return Figure(name, None, None, unit, "unknown", words, advice)


class Reading(Struct, frozen=True):
    """What one step found.  inputs: digests by name; refused: why the files could not be used, None if they could."""

    inputs: dict[str, str] = {}
    figures: list[Figure] = []
    notes: list[str] = []
    pictures: dict[str, str] = {}
    refused: str | None = None


class Wish(Struct, frozen=True):
    """What the builder wants, and measured by hand.

    thickness_mm: of the sheet by a calliper; measured_scale: measured over stated length of the chart's scale bars;
    distance_m, focal_px: of the photo of the pitch test.
    """

    name: str = "First Badge"
    lens: str = "50lpi"
    printer_dpi: int = 1200
    paper: Literal["a4", "letter"] = "a4"
    thickness_mm: Annotated[float, Meta(gt=0)] | None = None
    measured_scale: tuple[float, float] | None = None
    distance_m: Annotated[float, Meta(gt=0)] | None = None
    focal_px: Annotated[float, Meta(gt=0)] | None = None


class BuildState(Struct, frozen=True):
    """The state of a folder; files: paths of films and photographs elsewhere, by their names here."""

    format: Literal[1]
    kind: Literal["first-badge"]
    wish: Wish = Wish()
    files: dict[str, str] = {}
    readings: dict[str, Reading] = {}


#: What the pitch test is printed for.
PRINTED_FOR = ("lens", "printer_dpi", "paper")


@dataclass(frozen=True)
class BuildFolder:
    """A folder and its state; every change gives another one."""

    path: Path
    state: BuildState

    @property
    def wish(self) -> Wish:
        """What the builder wants."""
        return self.state.wish

    def at(self, name: str) -> Path:
        """The path of a file that moireid writes."""
        return self.path / name

    def found(self, name: str) -> Path | None:
        """A photograph or film by its well-known name; None where there is none.

        Raises: SpecError where there are several, or one in a format that cannot be read.
        """
        if (elsewhere := self.state.files.get(name)) is not None:
            return Path(elsewhere)
        suffixes = PHOTO_SUFFIXES + FILM_SUFFIXES + UNREADABLE
        there = sorted(p for p in self.path.glob(f"{name}.*") if p.suffix.lower() in suffixes)
        if len(there) > 1:
            names = " and ".join(path.name for path in there)
            raise SpecError(f"{self.path} has {names}; keep one of them, as both are {name}")
        if there and there[0].suffix.lower() in UNREADABLE:
            raise SpecError(f"{there[0]} is in a format that moireid does not read; export it as JPEG")
        return there[0] if there else None

    def reading(self, step: str) -> Reading | None:
        """What a step found; None where it was not done."""
        return self.state.readings.get(step)

    def figures(self) -> list[Figure]:
        """All figures, in the order of the steps."""
        return [figure for reading in self.state.readings.values() for figure in reading.figures]

    def with_reading(self, step: str, reading: Reading) -> BuildFolder:
        """The folder with what a step found."""
        readings = self.state.readings | {step: reading}
        return BuildFolder(self.path, msgspec.structs.replace(self.state, readings=readings))

    def save(self) -> None:
        """Write the state, whole or not at all."""
        text = msgspec.json.format(msgspec.json.encode(self.state), indent=1).decode()
        write_text(self.at(STATE), text + "\n")


def open_folder(path: Path, wished: Mapping[str, Any], files: Mapping[str, Path]) -> BuildFolder:
    """The folder, made where it does not exist, with what is wished now.

    Parameters: wished: fields of `Wish` that were given, None for others; files: paths by well-known names.
    Raises: SpecError where the folder holds files that would be replaced, or was begun for another sheet, printer or
        paper; and for a sheet that is not known.
    """
    if not (path / STATE).exists() and (taken := [name for name in OWN_FILES if (path / name).exists()]):
        raise SpecError(
            f"{path / taken[0]} exists already, and {path} was not begun by moireid first-badge; give a new folder"
        )
    state = _state_in(path)
    given = {key: value for key, value in wished.items() if value is not None}
    wish = msgspec.structs.replace(state.wish, **given)
    # A sheet that is not known is refused before anything is made for it.
    lens_named(wish.lens)
    changed = [key for key in PRINTED_FOR if getattr(wish, key) != getattr(state.wish, key)]
    if changed and any(reading.refused is None for reading in state.readings.values()):
        key = changed[0]
        raise SpecError(
            f"{path} was begun with {key}={getattr(state.wish, key)}, and {getattr(wish, key)} is given; give another "
            "folder for another sheet, printer or paper"
        )
    missing = [str(one) for one in files.values() if not one.is_file()]
    if missing:
        raise SpecError(f"{missing[0]} does not exist or is no file; give a photograph or film that is there")
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise SpecError(f"folder {path} cannot be made ({error.strerror}); choose another one") from error
    elsewhere = state.files | {name: str(one.absolute()) for name, one in files.items()}
    return BuildFolder(path, msgspec.structs.replace(state, wish=wish, files=elsewhere))


def _state_in(path: Path) -> BuildState:
    """The state of a folder; an empty one for a folder without."""
    file = path / STATE
    if not file.exists():
        return BuildState(1, "first-badge")
    source = str(file)
    try:
        text = file.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise SpecError(f"{source} cannot be read; {ADVICE}") from error
    document = parse_json(text, source, ADVICE)
    check_format(document, FORMAT, source)
    return read_model(document, BuildState, source, ADVICE)


def digests(paths: Iterable[Path], wished: Mapping[str, Any]) -> dict[str, str]:
    """What a step depends on: digests of files by their names, and values of the wish as text."""
    found = {}
    for path in paths:
        with path.open("rb") as file:
            found[path.name] = hashlib.file_digest(file, "sha256").hexdigest()
    return found | {key: str(value) for key, value in wished.items()}
