"""The list of a labelled collection, read and fully checked before any film is opened.

Convention: paths are relative to the manifest.  A label is `genuine`, `forged` or
    `forged:KIND`, as `moireid simulate` writes into the truth of a film.  A claim is the path of a badge file (it ends
    with .json), or a name or id in the registry.  An empty claim means the badge given on the command line.  An empty
    group means the label.
"""

from __future__ import annotations

import os
import re
from dataclasses import dataclass
from pathlib import Path

from moireid.asbuilt import AsBuilt, DatedFigures, as_built_from_json, dated_figures
from moireid.badge import Badge, load_badge
from moireid.errors import MoireIdError, SpecError
from moireid.provenance import Revocation
from moireid.registry import Record, Registry, open_registry
from moireid_lab.baseline.corners import Corners, read_corners
from moireid_lab.evaluation.csv_lists import read_list

COLUMNS = ("video", "label", "claim", "group")
OPTIONAL = ("corners",)
EXAMPLE = f"give a CSV file whose first line is {','.join(COLUMNS)}, with corners as a fifth column if need be"
LABEL = re.compile(r"genuine|forged(:[\w.-]+)?")
ADVICE = "write its path relative to the manifest"


@dataclass(frozen=True)
class ManifestClaim:
    """The claimed badge of a film, with its entry in the registry."""

    badge: Badge
    as_built: AsBuilt | None = None
    barred: Revocation | None = None
    earlier: tuple[DatedFigures, ...] = ()


@dataclass(frozen=True)
class Entry:
    """One film of the collection.

    line: number in the manifest; name: the film as written there; video: its path; stamp: as the function.
    """

    line: int
    name: str
    video: str
    stamp: str
    label: str
    claim: str
    group: str
    claimed: ManifestClaim
    corners: Corners | None = None

    @property
    def genuine(self) -> bool:
        """Whether the film is genuine."""
        return self.label == "genuine"


@dataclass(frozen=True)
class Manifest:
    """All films, and the columns that are not used."""

    entries: tuple[Entry, ...]
    unused: tuple[str, ...]


def read_manifest(
    path: str | os.PathLike[str], *, registry_url: str | None = None, badge: Badge | None = None
) -> Manifest:
    """Read a manifest, with every badge and every corner file that it names.

    Parameters: registry_url: of the registry for names and ids, None for the default; it is opened only if needed.
        badge: for films without a claim.
    Raises: SpecError if the file is not such a list, or has bad rows; the first is named and the rest are counted.
    """
    base = Path(path).absolute()
    header, rows = read_list(base, "manifest", COLUMNS, EXAMPLE)
    claims = _Claims(base.parent, registry_url, badge)
    entries, wrong = [], []
    try:
        for line, row in rows:
            try:
                entries.append(_entry(line, row, base.parent, claims))
            except MoireIdError as error:
                wrong.append(f"line {line} of {base.name} ({row['video'][:60]!r}): {error}")
    finally:
        claims.close()
    if wrong:
        more = f" ({len(wrong) - 1} more lines cannot be used either)" if len(wrong) > 1 else ""
        raise SpecError(wrong[0] + more)
    if not entries:
        raise SpecError(f"manifest {base} names no film; {EXAMPLE}, and a line for each film")
    return Manifest(tuple(entries), tuple(name for name in header if name not in (*COLUMNS, *OPTIONAL)))


def stamp(film: Path) -> str:
    """What changes with a file: its size and time.  Raises: SpecError if there is no such file."""
    try:
        found = film.stat()
    except OSError as error:
        raise SpecError(f"there is no film {str(film)!r} ({error.strerror}); {ADVICE}") from error
    if not film.is_file():
        raise SpecError(f"there is no film {str(film)!r} (it is a folder); {ADVICE}")
    return f"{found.st_size} {found.st_mtime_ns}"


def _entry(line: int, row: dict[str, str], folder: Path, claims: _Claims) -> Entry:
    """One line, checked.  Raises: MoireIdError if it cannot be used."""
    video, label = folder / row["video"], row["label"]
    if not row["video"]:
        raise SpecError(f"there is no film '' (the line names none); {ADVICE}")
    known = stamp(video)
    if not LABEL.fullmatch(label):
        raise SpecError(f"label {label[:40]!r} is not known; give genuine, forged, or forged:KIND")
    corners = read_corners(folder / row["corners"]) if row.get("corners") else None
    claimed = claims.find(row["claim"])
    return Entry(line, row["video"], str(video), known, label, row["claim"], row["group"] or label, claimed, corners)


class _Claims:
    """Looks up claims, each one once."""

    def __init__(self, folder: Path, registry_url: str | None, badge: Badge | None) -> None:
        self._folder, self._url, self._badge = folder, registry_url, badge
        self._registry: Registry | None = None
        self._found: dict[str, ManifestClaim] = {}

    def find(self, claim: str) -> ManifestClaim:
        """The badge of a claim.  Raises: MoireIdError if there is none."""
        if claim not in self._found:
            self._found[claim] = self._look_up(claim)
        return self._found[claim]

    def close(self) -> None:
        """Close the registry if it was opened."""
        if self._registry is not None:
            self._registry.close()

    def _look_up(self, claim: str) -> ManifestClaim:
        if not claim:
            if self._badge is None:
                raise SpecError("it has no claim, and no badge is given for such films; fill it in, or add --badge")
            return ManifestClaim(self._badge)
        if claim.lower().endswith(".json"):
            return ManifestClaim(load_badge(self._folder / claim))
        if self._registry is None:
            self._registry = open_registry(self._url, create=False)
            self._registry.standing()
        record: Record = self._registry.find(claim)
        as_built = as_built_from_json(record.as_built) if record.as_built else None
        return ManifestClaim(record.badge, as_built, record.barred(), dated_figures(record.earlier_figures))
