"""Measuring a capture: what the studio's child process does with an uploaded film."""

from __future__ import annotations

import json
from pathlib import Path

from moireid.badge import badge_from_json
from moireid.verifier.session.capture import capture_as_built
from moireid.web.jobs.task import Progress, Tell


def measure_capture(video: Path, progress: Progress, tell: Tell, *, badge_json: str) -> None:
    """The as-built figures of the badge in a film, as `moireid enroll --capture` measures them; nothing is stored.

    Raises: MediaError where the film cannot be read or does not show this badge in motion.
    """
    badge = badge_from_json(badge_json)
    found = capture_as_built([video], badge, progress=progress)
    tell({"result": {"kind": "capture", "id": badge.id, "as_built": json.loads(found.to_json())}})
