"""No claim: who is it, if anyone enrolled?

The film is read once for each layout among the enrolled badges, usually one; the payload is decoded without looking
at anybody's pitches, and then looked up.  A film whose fringes break the motion law shows nobody's badge.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from moireid.badge import Badge
from moireid.verifier.reasons import Reason
from moireid.verifier.track import Progress
from moireid.verifier.verify import Report, verify

Finding = Literal["found", "nobody", "inconclusive"]


@dataclass(frozen=True)
class Identification:
    """Outcome of an identification: whose id, and the report that it rests on (None where nobody is enrolled)."""

    finding: Finding
    found_id: str | None
    reasons: tuple[Reason, ...]
    report: Report | None

    def to_json(self) -> dict[str, Any]:
        """The object that `identify --json` prints, whose keys contain those of `verify --json`."""
        document: dict[str, Any] = self.report.to_json() if self.report else {}
        return document | {
            "finding": self.finding, "found_id": self.found_id, "reasons": [r.to_json() for r in self.reasons],
        }  # fmt: skip


def identify(
    video: Path,
    layouts: Iterable[Badge],
    is_enrolled: Callable[[str], bool],
    *,
    focal_px: float | None = None,
    progress: Progress | None = None,
) -> Identification:
    """Find the enrolled badge that a film shows.

    Parameters: layouts: one badge for each layout enrolled; is_enrolled: whether an id was issued and is not revoked.
    Convention: "found" needs a decoded, enrolled id *and* the invariant; "nobody" a readable badge that is not
        enrolled, or fringes that break the law.
    Returns: Identification, of the layout that says most.
    Raises: MediaError where the film cannot be read.
    Source: `verify` without a claim, a layout at a time.
    """
    order = {"found": 0, "nobody": 1, "inconclusive": 2}
    outcomes = [
        _judge(verify(video, layout, claimed_id=None, focal_px=focal_px, progress=progress), is_enrolled)
        for layout in layouts
    ]
    if not outcomes:
        reason = Reason("enrolled", "fail", 0.0, 1.0, "badges", "Nobody is enrolled in this registry yet.")
        return Identification("nobody", None, (reason,), None)
    return min(outcomes, key=lambda outcome: order[outcome.finding])


def _judge(report: Report, is_enrolled: Callable[[str], bool]) -> Identification:
    """The finding of one layout's report."""
    invariant, decoded = report.invariant, report.identity.decoded_id
    if invariant.verdict == "reject":
        reason = Reason(
            "genuine", "fail", None, None, "", "The fringes break the motion law, so this is nobody's badge."
        )
        return Identification("nobody", None, (*invariant.reasons, reason), report)
    if decoded is None:
        reason = Reason("identity", "undecided", None, None, "", "No identity can be read off the badge.")
        return Identification("inconclusive", None, (*report.reasons, reason), report)
    if not is_enrolled(decoded):
        reason = Reason(
            "enrolled",
            "fail",
            decoded,
            None,
            "",
            f"The badge reads {decoded}, which nobody holds here: not issued, or revoked.",
        )
        return Identification("nobody", None, (*invariant.reasons, reason), report)
    reason = Reason("enrolled", "pass", decoded, None, "", f"The badge reads {decoded}, which is enrolled.")
    if invariant.verdict == "inconclusive":
        return Identification("inconclusive", decoded, (*invariant.reasons, reason), report)
    return Identification("found", decoded, (*invariant.reasons, reason), report)
