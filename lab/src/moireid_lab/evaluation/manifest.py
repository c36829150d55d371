"""The list of a labelled collection, read and fully checked before any film is opened.

Convention: the manifest and the files in it are given by address (`archive.addresses`): plain paths, or s3://... if the
    protocol's package is installed.  Paths are relative to the manifest. A label is `genuine`, `forged` or
    `forged:KIND`, as `moireid simulate` writes into the truth of a film.  A claim is the path of a badge file (it ends
    with .json), or a name or id in the registry.  An empty claim means the badge given on the command line.  An empty
    group means the label.
"""

from __future__ import annotations

import csv
import io
import os
import re
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

from moireid.asbuilt import AsBuilt, DatedFigures, as_built_from_json, dated_figures
from moireid.badge import Badge, load_badge
from moireid.errors import MoireIdError, SpecError
from moireid.provenance import Exclusion
from moireid.registry import Record, Registry, open_registry
from moireid_lab.archive.addresses import fetched, is_address, joined, read_text, stamp
from moireid_lab.baseline.corners import ENTRIES, Corners, corners_from, read_corners

COLUMNS = ("video", "label", "claim", "group")
OPTIONAL = ("corners",)
EXAMPLE = f"give a CSV file whose first line is {','.join(COLUMNS)}, with corners as a fifth column if need be"
LABEL = re.compile(r"genuine|forged(:[\w.-]+)?")
#: Number of threads that check films, as remote storage answers slowly.
LOOKERS = 16
#: Largest badge file or file of corners.
MOST_MB = 16.0


@dataclass(frozen=True)
class ManifestClaim:
    """The claimed badge of a film, with its entry in the registry."""

    badge: Badge
    as_built: AsBuilt | None = None
    barred: Exclusion | None = None
    earlier: tuple[DatedFigures, ...] = ()


@dataclass(frozen=True)
class Entry:
    """One film of the collection.

    line: number in the manifest; name: the film as written there; video: its address; stamp: as `addresses.stamp`.
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
    address: str | os.PathLike[str], *, registry_url: str | None = None, badge: Badge | None = None
) -> Manifest:
    """Read a manifest, with every badge and every corner file that it names.

    Parameters: address: a path, or an address for fsspec.  registry_url: of the registry for names and ids, None for
        the default; it is opened only if needed.  badge: for films without a claim.
    Raises: SpecError if the file is not such a list, or has bad rows; the first is named and the rest are counted.
    """
    base = os.fspath(address)
    base = base if is_address(base) else os.path.abspath(base)
    header, rows = _rows(base)
    claims = _Claims(base, registry_url, badge)
    entries, wrong = [], []
    try:
        for (line, row), looked in zip(rows, _stamps(base, [row["video"] for _, row in rows]), strict=True):
            try:
                entries.append(_entry(line, row, base, looked, claims))
            except MoireIdError as error:
                wrong.append(f"line {line} of {_short(base)} ({row['video'][:60]!r}): {error}")
    finally:
        claims.close()
    if wrong:
        more = f" ({len(wrong) - 1} more lines cannot be used either)" if len(wrong) > 1 else ""
        raise SpecError(wrong[0] + more)
    if not entries:
        raise SpecError(f"manifest {base} names no film; {EXAMPLE}, and a line for each film")
    return Manifest(tuple(entries), tuple(name for name in header if name not in (*COLUMNS, *OPTIONAL)))


def _rows(base: str) -> tuple[list[str], list[tuple[int, dict[str, str]]]]:
    """The columns, and number and cells of each non-empty line."""
    try:
        reader = csv.reader(io.StringIO(read_text(base), newline=""), strict=True)
        lines = [(reader.line_num, [cell.strip() for cell in row]) for row in reader]
    except csv.Error as error:
        raise SpecError(f"manifest {base} cannot be read (no CSV: {error}); {EXAMPLE}") from error
    except SpecError as error:
        raise SpecError(f"manifest {error}; {EXAMPLE}") from error
    header = [name.lower() for name in lines[0][1]] if lines else []
    lacking = [name for name in COLUMNS if name not in header]
    if lacking or len(set(header)) < len(header):
        fault = f"has no column {' and no column '.join(lacking)}" if lacking else "names a column twice"
        raise SpecError(f"manifest {base} {fault}, its first line is {','.join(header)[:80]!r}; {EXAMPLE}")
    rows = []
    for line, cells in lines[1:]:
        if not any(cells):
            continue
        if len(cells) > len(header):
            raise SpecError(
                f"line {line} of {_short(base)} has {len(cells)} cells, the first line {len(header)}; put names that "
                "hold a comma in double quotes"
            )
        rows.append((line, dict.fromkeys(header, "") | dict(zip(header, cells, strict=False))))
    return header, rows


def _short(base: str) -> str:
    """The file's own name, for messages."""
    return base.rpartition("/")[2]


def _stamps(base: str, names: Sequence[str]) -> list[str | MoireIdError]:
    """The stamp of each film, or the error on access."""

    def look(name: str) -> str | MoireIdError:
        try:
            if not name:
                raise SpecError("there is no film '' (the line names none); write its path relative to the manifest")
            return stamp(joined(base, name))
        except MoireIdError as error:
            return error

    with ThreadPoolExecutor(LOOKERS) as pool:
        return list(pool.map(look, names))


def _entry(line: int, row: dict[str, str], base: str, looked: str | MoireIdError, claims: _Claims) -> Entry:
    """One line, checked.  Raises: MoireIdError if it cannot be used."""
    label = row["label"]
    if not isinstance(looked, str):
        raise looked
    if not LABEL.fullmatch(label):
        raise SpecError(f"label {label[:40]!r} is not known; give genuine, forged, or forged:KIND")
    corners = _corners(base, row["corners"]) if row.get("corners") else None
    claimed = claims.find(row["claim"])
    return Entry(
        line,
        row["video"],
        joined(base, row["video"]),
        looked,
        label,
        row["claim"],
        row["group"] or label,
        claimed,
        corners,
    )


def _corners(base: str, given: str) -> Corners:
    """Corners from the cell itself, or from a file by address."""
    if ENTRIES.fullmatch(given.strip()):
        return corners_from(given)
    with fetched(joined(base, given), most_mb=MOST_MB) as path:
        return read_corners(path)


class _Claims:
    """Looks up claims, each one once."""

    def __init__(self, base: str, registry_url: str | None, badge: Badge | None) -> None:
        self._base, self._url, self._badge = base, registry_url, badge
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
            with fetched(joined(self._base, claim), most_mb=MOST_MB) as path:
                return ManifestClaim(load_badge(path))
        if self._registry is None:
            self._registry = open_registry(self._url, create=False)
            self._registry.standing()
        record: Record = self._registry.find(claim)
        as_built = as_built_from_json(record.as_built) if record.as_built else None
        return ManifestClaim(record.badge, as_built, record.barred(), dated_figures(record.earlier_figures))
