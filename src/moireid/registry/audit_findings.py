"""What an audit finds, and its counts while it runs."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

from moireid.registry.engine import AnyRow

#: Findings beyond this many are counted, not kept: a table torn to pieces must not fill the memory.
KEPT = 1000
#: Rows between two reports of progress.
STEP = 500


@dataclass(frozen=True)
class Finding:
    """A fault that an audit found in a registry.

    Attributes
    ----------
    code : str
        For programs.
    text : str
        One sentence for people.
    subject : str or None
        The id or the log entry that it is about; None if it is about the whole registry.
    """

    code: str
    text: str
    subject: str | None


@dataclass(frozen=True)
class Audit:
    """The result of an audit.

    Attributes
    ----------
    fingerprint : str
        Of the authority's public key, 32 hex digits.
    records : int
        Records looked at.
    revoked : int
        Those of them that are revoked.
    erased : int
        People who were erased.
    entries : int
        Entries of the log looked at.
    actors : mapping of str to int
        Number of entries by actor.
    head : str or None
        The log's head, SEQUENCE:HASH; None if it is not valid.
    findings : tuple of Finding
        The first `KEPT` faults of `found`.
    found : int
        Number of faults.
    witnessed : mapping or None
        Of the newest checkpoint that the witnesses signed: `size`, and `signers`, name to time; None if none was asked
        for.

    Notes
    -----
    Convention: `sound` is true if nothing was found.  `moireid.registry.audit` lists what an audit cannot show by
    itself.
    """

    fingerprint: str
    records: int
    revoked: int
    entries: int
    head: str | None
    findings: tuple[Finding, ...]
    found: int
    erased: int = 0
    witnessed: Mapping[str, Any] | None = None
    actors: Mapping[str, int] = field(default_factory=dict)

    @property
    def sound(self) -> bool:
        """Whether no fault was found."""
        return self.found == 0

    def to_json(self) -> dict[str, Any]:
        """Make the JSON object that ``moireid registry audit --json`` prints.

        Returns
        -------
        dict
            An object that JSON can hold.
        """
        fields = asdict(self)
        return {"sound": self.sound, "badges": fields.pop("records")} | fields


class Tally:
    """The counts of a running audit: those of `Audit`, and what is needed to make them."""

    def __init__(self, progress: Callable[[int, int | None], None] | None, total: int) -> None:
        self._progress, self._total = progress, total
        self.counts: Counter[str] = Counter(records=0, revoked=0, erased=0, entries=0, found=0)
        #: Number of entries by their actor.
        self.actors: Counter[str] = Counter()
        #: Ids of badges whose holders were erased.
        self.ended: set[str] = set()
        self.findings: list[Finding] = []
        #: Hash of each record's newest version by the entries that were looked at.
        self.newest: dict[str, str] = {}

    def report(self, code: str, text: str, subject: object = None) -> None:
        """Count a finding, and keep it if there are not too many."""
        self.counts["found"] += 1
        if len(self.findings) < KEPT:
            self.findings.append(Finding(code, text, None if subject is None else str(subject)))

    def counted(self, what: str, rows: Iterable[AnyRow]) -> Iterator[AnyRow]:
        """The rows, each counted as one of `what`; the progress is reported at each `STEP` of them, and at the end."""
        for number, row in enumerate(rows, 1):
            self.counts[what] += 1
            yield row
            if number % STEP == 0:
                self._report_progress()
        self._report_progress()

    def _report_progress(self) -> None:
        if self._progress:
            self._progress(self.counts["records"] + self.counts["entries"], self._total)
