"""Golden rows: what the verifier says of a fixed corpus of films, before and after a change.

    .venv/bin/python benchmarks/golden.py FOLDER --make        the films, by the version `PINNED` (in 15 minutes)
    .venv/bin/python benchmarks/golden.py FOLDER --out NEW.csv --against benchmarks/golden.csv
    .venv/bin/python benchmarks/golden.py --signals --against benchmarks/golden.csv       without films, in seconds

A row is a film: a hash of its luma, verdict, codes of all findings, gain, identity with the id that is read, and odds.
`--against` prints what moved, and exits with 1 if a verdict, a code or an identity moved.  A film that another machine
made otherwise is another film: it is named, and not compared.

The corpus (`golden_films.py` of that version): the films of `tests/data`, badges on natural motion, each effect of the
simulator, outside films of all formats, each forgery on four motions, boards that were built wrong, long lenses.  Of
half-real films (`moireid lab bench half-real --keep DIR`, `real-…` and `forged-real-…`), which show a person, only the
signals are kept: `golden.py DIR --only real- --keep tests/data/golden --out NEW.csv`.
`--signals` judges what `--keep` kept of each film (`tests/data/golden`): the signals, from which motion is judged
again, and the other findings, identity among them, as they were.
"""

from __future__ import annotations

import argparse
import csv
import hashlib
import os
import re
import subprocess
import sys
import zlib
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import av
import msgspec
import numpy as np

from moireid.badge import load_badge
from moireid.verifier import Question, Report, verify
from moireid.verifier.decision.judge import Invariant, judge
from moireid.verifier.decision.sheet_gain import SheetGain
from moireid.verifier.fringes.grating_signal import GratingSignal
from moireid.verifier.identity.cell_slip import RowsApart
from moireid.verifier.reasons import Reason, worst
from moireid.verifier.session.claim import sheet_of

PINNED = "cb5626d9822c3f0764c2fa6ce0a8b1d915ec5b80"
ROOT = Path(__file__).parents[1]
SIGNALS = ROOT / "tests" / "data" / "golden"
KINDS = ("*.mp4", "*.signals")
COLUMNS = ("case", "luma", "verdict", "codes", "gain", "identity", "read", "score", "calibrated_log10")
#: What may not move at all, and the columns of figures.
EXACT, GAINS, ODDS = ("verdict", "codes", "identity", "read"), ("gain",), ("score", "calibrated_log10")
#: Beyond the signals, what a report is judged by again: keys of its JSON.
KEPT = ("claim_source", "badge", "identity", "frames", "cover", "camera")
Row = dict[str, str]


@dataclass(frozen=True)
class KeptFilm:
    """What is kept of a film: its luma's hash, its signals, and what else its report was judged by.

    others: findings that are not on motion; document: keys `KEPT` of the report.
    """

    luma: str
    signals: tuple[GratingSignal, ...]
    sheet: SheetGain
    apart: RowsApart
    page_off: bool
    others: tuple[Reason, ...]
    document: dict[str, Any]

    @classmethod
    def of(cls, report: Report, sheet: SheetGain, luma: str) -> KeptFilm:
        """What is kept of a film that was verified."""
        signals = report.measurement.gratings if report.measurement else ()
        on_motion = report.invariant.reasons if signals else ()
        document, identity = report.to_json(), report.identity
        others = tuple(reason for reason in report.reasons if reason not in on_motion)
        kept = {name: document[name] for name in KEPT}
        return cls(luma, signals, sheet, identity.rows_apart, identity.page_off, others, kept)

    def judged(self) -> tuple[Invariant, list[Reason]]:
        """The motion test, anew, and all findings."""
        if not self.signals:
            return Invariant("inconclusive", ()), list(self.others)
        motion = judge(self.signals, self.sheet, code_apart=self.apart, page_off=self.page_off)
        return motion, [*motion.reasons, *self.others]

    def report(self) -> dict[str, Any]:
        """The report as JSON, as far as a headline needs it."""
        motion, reasons = self.judged()
        return self.document | {
            "verdict": worst(reasons),
            "reasons": [reason.to_json() for reason in reasons],
            "invariant": motion.to_json(),
            "explanations": [one.to_json() for one in motion.explanations],
        }

    def to_bytes(self) -> bytes:
        """As a file: MessagePack, compressed."""
        return zlib.compress(msgspec.msgpack.encode(self, enc_hook=_stored), 9)

    @classmethod
    def from_bytes(cls, data: bytes) -> KeptFilm:
        """What `to_bytes` wrote."""
        return msgspec.msgpack.decode(zlib.decompress(data), type=cls, dec_hook=_restored)


def _stored(value: Any) -> Any:
    """An array as its type, shape and bytes; a number of NumPy as Python's."""
    return (value.dtype.str, value.shape, value.tobytes()) if isinstance(value, np.ndarray) else value.item()


def _restored(_: type, value: Any) -> np.ndarray:
    """An array of what `_stored` gave."""
    kind, shape, data = value
    return np.frombuffer(data, kind).reshape(shape)


def luma_hash(film: Path) -> str:
    """A hash of the luma of all frames."""
    found = hashlib.sha256()
    with av.open(str(film)) as container:
        for frame in container.decode(video=0):
            found.update(frame.to_ndarray(format="gray").tobytes())
    return found.hexdigest()[:16]


def of_film(film: Path, keep: Path | None = None) -> Row:
    """The row of a film, next to which its badge is."""
    badge = load_badge(film.with_name(f"{film.stem}.json"))
    claim, luma = Question(badge, badge.id), luma_hash(film)
    report = verify(film, claim)
    if keep is not None:
        (keep / f"{film.stem}.signals").write_bytes(KeptFilm.of(report, sheet_of(claim), luma).to_bytes())
    return row_of(film.stem, luma, report.invariant, report.reasons, report.to_json()["identity"])


def of_signals(path: Path) -> Row:
    """The row of what was kept of a film."""
    kept = KeptFilm.from_bytes(path.read_bytes())
    motion, reasons = kept.judged()
    return row_of(path.stem, kept.luma, motion, reasons, kept.document["identity"])


def row_of(case: str, luma: str, motion: Invariant, reasons: Sequence[Reason], identity: dict[str, Any]) -> Row:
    """One row."""
    codes = " ".join(sorted({f"{reason.code}:{reason.level}" for reason in reasons}))
    figures = (motion.gain_ratio, motion.score, motion.calibrated_log10)
    gain, score, odds = ("" if figure is None else f"{figure:.9g}" for figure in figures)
    found = (
        case,
        luma,
        worst(list(reasons)),
        codes,
        gain,
        identity["verdict"],
        identity["decoded_id"] or "",
        score,
        odds,
    )
    return dict(zip(COLUMNS, found, strict=True))


def moved(old: Iterable[Row], new: Iterable[Row], gain: float, odds: float) -> Iterator[tuple[bool, str]]:
    """What moved, in words, and whether it counts.  Parameters: gain, odds: what these may move by."""
    before = {row["case"]: row for row in old}
    for row in new:
        case, was = row["case"], before.get(row["case"])
        if was is None or was["luma"] != row["luma"]:
            yield False, f"{case}: {'no old row' if was is None else 'another film'}"
            continue
        for name in EXACT:
            if was[name] != row[name]:
                yield True, f"{case}: {name} {_change(was[name], row[name])}"
        for name, most in (*((one, gain) for one in GAINS), *((one, odds) for one in ODDS)):
            if _apart(was[name], row[name]) > most:
                yield False, f"{case}: {name} {was[name] or '-'} -> {row[name] or '-'}"


def _change(old: str, new: str) -> str:
    """Of codes only those that came and went."""
    was, now = set(old.split()), set(new.split())
    if len(was | now) < 3:
        return f"{old or '-'} -> {new or '-'}"
    return " ".join([*(f"-{word}" for word in sorted(was - now)), *(f"+{word}" for word in sorted(now - was))])


def _apart(old: str, new: str) -> float:
    """How far two figures differ; infinitely, if only one is known."""
    if not old or not new:
        return 0.0 if old == new else float("inf")
    return abs(float(old) - float(new))


def is_forged(case: str) -> bool:
    """Whether a film of this name ought not to be accepted."""
    return case.startswith(("forged-", "data-forged")) and not case.startswith("forged-true")


def make(folder: Path, only: str, workers: int) -> None:
    """Make the films in a checkout of the pinned version."""
    source = folder / "source"
    if not source.exists():
        source.mkdir(parents=True)
        command = ["git", "-C", str(ROOT), "archive", PINNED]
        archive = subprocess.run(command, check=True, stdout=subprocess.PIPE).stdout
        subprocess.run(["tar", "-x", "-C", str(source)], check=True, input=archive)
    paths = os.pathsep.join(str(source / one) for one in ("src", "lab/src", "benchmarks"))
    made_by = source / "benchmarks" / "golden_films.py"
    script = [sys.executable, "-P", str(made_by), str(folder), only, str(workers)]
    subprocess.run(script, check=True, env=os.environ | {"PYTHONPATH": paths})


def judged_rows(source: Path, only: str, workers: int, keep: Path | None) -> list[Row]:
    """The rows of a folder of films or kept signals, or of a table."""
    if source.is_file():
        return [row for row in read_rows(source) if re.search(only, row["case"])]
    if keep is not None:
        keep.mkdir(parents=True, exist_ok=True)
    films, signals = (sorted(path for path in source.glob(kind) if re.search(only, path.stem)) for kind in KINDS)
    with ProcessPoolExecutor(workers) as pool:
        from_films = pool.map(partial(of_film, keep=keep), films)
        return [*from_films, *pool.map(of_signals, signals)]


def write_rows(rows: Iterable[Row], path: Path) -> None:
    """Rows as CSV, below a line that says where they are from."""
    with path.open("w", encoding="utf-8", newline="") as stream:
        stream.write(f"# By benchmarks/golden.py, which says how; films made by {PINNED[:8]}.\n")
        writer = csv.DictWriter(stream, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def read_rows(path: Path) -> list[Row]:
    """Rows of a file; lines that begin with # are words."""
    lines = path.read_text(encoding="utf-8").splitlines()
    return list(csv.DictReader(line for line in lines if not line.startswith("#")))


def main(arguments: Sequence[str] | None = None) -> int:
    """Make, judge, compare.  Returns: 1 if a verdict, a code or an identity moved."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("source", nargs="?", type=Path, help="folder of films, or a table of rows")
    parser.add_argument("--make", action="store_true", help="make the films that are not in the folder")
    parser.add_argument("--signals", action="store_true", help="judge the kept signals, not films")
    parser.add_argument("--only", default="", metavar="REGEX", help="only the cases whose name holds this")
    parser.add_argument("--workers", type=int, default=1, metavar="N", help="films at a time")
    parser.add_argument("--keep", type=Path, metavar="DIR", help="keep the signals of films there")
    parser.add_argument("--out", type=Path, metavar="CSV", help="write the rows")
    parser.add_argument("--against", type=Path, metavar="CSV", help="older rows: print what moved")
    parser.add_argument("--gain", type=float, default=1e-6, help="what a gain may move by")
    parser.add_argument("--odds", type=float, default=1e-3, help="what odds may move by, powers of ten")
    given = parser.parse_args(arguments)
    if given.signals == (given.source is not None):
        parser.error("give a folder of films, a table of rows, or --signals")
    if given.make:
        make(given.source.resolve(), given.only, given.workers)
        return 0
    rows = judged_rows(SIGNALS if given.signals else given.source, given.only, given.workers, given.keep)
    for forged in (False, True):
        given_verdicts = [row["verdict"] for row in rows if is_forged(row["case"]) == forged]
        words = ", ".join(f"{given_verdicts.count(one)} {one}" for one in ("accept", "inconclusive", "reject"))
        print(f"{len(given_verdicts)} {'forged' if forged else 'honest'} films: {words}")
    if given.out:
        write_rows(rows, given.out)
    if not given.against:
        return 0
    found = list(moved(read_rows(given.against), rows, given.gain, given.odds))
    print("".join(f"{words}\n" for _, words in found), end="")
    count = sum(counts for counts, _ in found)
    print(f"{len(rows)} films: {count} verdicts, codes or identities moved, {len(found) - count} other differences")
    return int(count > 0)


if __name__ == "__main__":
    sys.exit(main())
