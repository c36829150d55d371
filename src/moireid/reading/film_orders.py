"""Orders to read films: pickled for the process that reads, and carried out by `FilmOrder.read` there.

Convention: an order holds no key, no registry and no address.  Results are sent as JSON, as `Child.hear` reads them.
"""

from __future__ import annotations

import base64
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from moireid.badge import Badge
from moireid.extras import missing_extra
from moireid.provenance import Exclusion

if TYPE_CHECKING:
    from moireid.verifier.camera.known_camera import KnownCamera
    from moireid.verifier.session.claim import Claim
    from moireid.verifier.session.result import Report

#: Callbacks of the process that reads: a part of the result; a question to the process that ordered; frames read.
Send = Callable[[dict[str, Any]], None]
Ask = Callable[[dict[str, Any]], Any]
Progress = Callable[[int, int | None], None]


class FilmOrder(Protocol):
    """What to read of a film."""

    def read(self, send: Send, ask: Ask, progress: Progress) -> None:
        """Read the film and send what was found, under "result" and further keys."""


@dataclass(frozen=True)
class JudgingOrder:
    """A report on a film, as `verifier.verify` makes it; pictures: whether those of its page are drawn too.

    pipeline: "published" for the published method; track: the video track, None for the only one.
    """

    video: Path
    claim: Claim
    barred: Exclusion | None = None
    overlap: bool = False
    pictures: bool = False
    pipeline: str = "moireid"
    track: int | None = None

    def read(self, send: Send, ask: Ask, progress: Progress) -> None:
        """Send the report; then, if asked for, its files, plots and signals."""
        from moireid.verifier.report.report_page import pictures_of, signals_csv

        report = self._report(progress)
        send({"result": report.to_json()})
        if self.pictures:
            drawn = pictures_of(report)
            files = {name: base64.b64encode(content).decode() for name, content in drawn.files.items()}
            send({"files": files, "plots": list(drawn.plots), "frame_s": drawn.frame_s})
            send({"signals": signals_csv(report)})

    def _report(self, progress: Progress) -> Report:
        if self.pipeline == "published":
            published: Report = published_method().verify_published(self.video, self.claim, progress=progress)
            return published
        from moireid.verifier.session.film import verify

        return verify(
            self.video, self.claim, barred=self.barred, overlap=self.overlap, track=self.track, progress=progress
        )


def published_method() -> Any:
    """The published method, which is in the lab.  Raises: MissingExtraError where that is not installed."""
    from importlib.metadata import entry_points

    for point in entry_points(group="moireid.pipelines", name="published"):
        return point.load()
    raise missing_extra("the published method", "moireid-lab", "", "moireid-lab")


@dataclass(frozen=True)
class EnrolledQuestions:
    """The registry as identification sees it: each question is answered by the process that has it."""

    ask: Ask

    def holds(self, badge_id: str) -> bool:
        """Whether that id is enrolled, and its badge counts at present."""
        return bool(self.ask({"holds": badge_id}))

    def alike(self, parts: Mapping[int, str]) -> list[str]:
        """Ids, revoked or not, of which a part reads so."""
        return list(self.ask({"alike": dict(parts)}))


@dataclass(frozen=True)
class IdentifyingOrder:
    """Whose badge a film shows, as `verifier.identify` finds it."""

    video: Path
    layouts: Sequence[Badge]
    focal_px: float | None = None
    camera: KnownCamera | None = None
    track: int | None = None

    def read(self, send: Send, ask: Ask, progress: Progress) -> None:
        """Send the finding."""
        from moireid.verifier.session.identify import identify

        found = identify(
            self.video,
            self.layouts,
            EnrolledQuestions(ask),
            focal_px=self.focal_px,
            camera=self.camera,
            track=self.track,
            progress=progress,
        )
        send({"result": found.to_json()})


@dataclass(frozen=True)
class CaptureOrder:
    """The as-built figures that films of a badge show, as `capture_as_built` measures them."""

    videos: tuple[Path, ...]
    badge: Badge
    focal_px: float | None = None
    camera: KnownCamera | None = None
    measured_scale: float | None = None
    track: int | None = None

    def read(self, send: Send, ask: Ask, progress: Progress) -> None:
        """Send the figures."""
        from moireid.verifier.session.capture import capture_as_built

        found = capture_as_built(
            list(self.videos),
            self.badge,
            focal_px=self.focal_px,
            camera=self.camera,
            measured_scale=self.measured_scale,
            track=self.track,
            progress=progress,
        )
        send({"result": json.loads(found.to_json())})
