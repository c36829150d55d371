"""The content credentials that a film carries, as a note in the report.

They say who vouches for a file, and nothing of the badge.  So they never count for a film, nor against it.
"""

from __future__ import annotations

from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path

from moireid.attest.credentials_work import read
from moireid.verifier.reasons import Reason
from moireid.verifier.session.result import Report


def with_carried(report: Report, film: Path) -> Report:
    """A report with a note of the credentials that its film carries; as it was where there are none.

    Without c2pa-python they are not looked for.
    """
    if find_spec("c2pa") is None or (found := read(film)) is None:
        return report
    state = found["state"]
    who = f"signed by {found['signer']!r}" if found["signer"] else "without a signer's name"
    words = {
        "Trusted": "they hold, and their certificate is trusted",
        "Valid": "they hold, by a certificate that is on no trust list known here",
    }.get(state, "they do not hold: the film or they were changed")
    text = f"The film carries content credentials, {who}; {words}. They are no part of the verdict."
    note = Reason("content_credentials", "note", state, None, "", text)
    return replace(report, reasons=(*report.reasons, note))
