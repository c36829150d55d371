"""What is kept of a watched live check, where that is asked for: the badge's figures, and a receipt."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from moireid.badge import Badge
from moireid.cli.common import say
from moireid.cli.enroll_cmd import figures_words, show_compared
from moireid.errors import SpecError
from moireid.files import write_text
from moireid.question import Question
from moireid.verifier.report.live_receipt import FilmAsked, LiveReceipt


def check_enrollable(found: Question) -> None:
    """Raise SpecError unless a registry vouches for the badge: by a file's lines anyone's badge could be measured."""
    if found.provenance.source != "registry":
        raise SpecError(
            "--enroll keeps figures in a registry that holds the badge; give --claim, or --badge with --registry, and "
            "enroll the badge there first (moireid enroll)"
        )


def enroll(badge: Badge, figures: object, registry_url: str | None, actor: str | None, reason: str | None) -> None:
    """Keep what an accepted check measured.  Raises: RegistryError where it is refused, SpecError where it is none."""
    from moireid.enrolment import keep_figures
    from moireid.registry import open_registry
    from moireid.verifier.session.known_figures import checked_figures

    if figures is None:
        say("note: nothing was enrolled, as the live check was not accepted")
        return
    found = checked_figures(figures, badge)
    with open_registry(registry_url, create=False, actor=actor) as registry:
        registry.check_head()
        show_compared(registry, badge, found, reason)
        record = keep_figures(registry, registry.find(badge.id or ""), found, reason)
    say(f"{record.name}: {figures_words(record, found)}")


def write_receipt(path: Path, document: Mapping[str, Any], found: Question, film: FilmAsked | None) -> None:
    """Write the receipt of a check; its digest is that of the line that --json prints."""
    line = json.dumps(document, ensure_ascii=False, allow_nan=False)
    receipt = LiveReceipt(
        "watch",
        found.badge.name,
        datetime.now(UTC).isoformat(timespec="seconds"),
        document["verdict"],
        hashlib.sha256(line.encode()).hexdigest(),
        document["challenged"],
        found.badge.id,
        film=film,
        registry=found.provenance.standing,
        sealed=tuple(document["sealed"]),
        decoder=document["input"]["decoder"],
    )
    write_text(path, json.dumps(receipt.to_json(), ensure_ascii=False, indent=1) + "\n")
    say(f"receipt: {path}")
