"""What an audit finds, and its counts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from moireid.registry.record import Fault

#: Findings beyond this many are counted, not kept: a table torn to pieces must not fill the memory.
KEPT = 1000


@dataclass
class Audit:
    """The result of an audit.

    Attributes
    ----------
    fingerprint : str
        Of the authority's public key, 32 hex digits.
    head : str or None
        The log's head, SEQUENCE:HASH; None if it is not valid.
    records : int
        Records looked at.
    revoked : int
        Those of them that are revoked.
    erased : int
        People who were erased.
    entries : int
        Entries of the log looked at.
    found : int
        Number of faults.
    findings : list of Fault
        The first `KEPT` of them.
    witnessed : mapping or None
        Of the newest checkpoint that the witnesses signed: `size`, and `signers`, name to time; None if none was asked
        for.

    Notes
    -----
    Convention: `sound` is true if nothing was found.  `moireid.registry.audit` lists what an audit cannot show by
    itself.
    """

    fingerprint: str
    head: str | None = None
    records: int = 0
    revoked: int = 0
    erased: int = 0
    entries: int = 0
    found: int = 0
    findings: list[Fault] = field(default_factory=list)
    witnessed: Mapping[str, Any] | None = None

    @property
    def sound(self) -> bool:
        """Whether no fault was found."""
        return self.found == 0

    def report(self, fault: Fault) -> None:
        """Count a finding, and keep it if there are not too many."""
        self.found += 1
        if len(self.findings) < KEPT:
            self.findings.append(fault)

    def to_json(self) -> dict[str, Any]:
        """Make the JSON object that ``moireid registry audit --json`` prints.

        Returns
        -------
        dict
            An object that JSON can hold.
        """
        fields = dict(vars(self))
        findings = [{"code": one.code, "text": one.text, "subject": one.subject} for one in self.findings]
        return {"sound": self.sound, "badges": fields.pop("records")} | fields | {"findings": findings}
