"""A verdict as a page: what a job's process found, with what the registry knows.

The registry is asked here, in the server.  The process that decoded the film gets the claimed badge alone, and never
learns whose badge it has read.  What that process says and leaves in its folder is not trusted: names of pictures must
be among ours, and a link is not followed.
"""

from __future__ import annotations

import os
from typing import Any

from moireid.registry import holder_of
from moireid.verifier.report.circumstances import Circumstances, read_id
from moireid.verifier.report.report_page import NAME, Pictures
from moireid_studio.problems import Refusal
from moireid_studio.store.job import Job
from moireid_studio.studio import Studio

#: Greatest number of plots, and letters of a plot's title.
MOST_PLOTS, MOST_LETTERS = 16, 80
#: Greatest size of a picture, or of the signals, that is read into the server's memory: signals take 200 bytes a frame,
#: and a frame of a 4K film as JPEG some megabytes.
KEPT_BYTES = 16 << 20


def circumstances_of(studio: Studio, job: Job) -> Circumstances:
    """How a job's check was made, and who holds the badge that it read.  Raises: RegistryError as `holder_of`."""
    read = holder_of(studio.registry, read_id(job.result or {}))
    # The registry's place is not for those who come from outside.
    return Circumstances(
        job.begun, job.film_name or None, job.claim or None, job.barred, read, job.standing or studio.standing()
    )


def list_pictures(job: Job) -> Pictures:
    """The pictures of a job by their names, without their contents."""
    named = [name for name in _texts(job.kept.get("files")) if NAME.fullmatch(name)]
    titles = [title[:MOST_LETTERS] for title in _texts(job.kept.get("plots"))][:MOST_PLOTS]
    there = [title for number, title in enumerate(titles) if f"plot{number}.svg" in named]
    frame_s = job.kept.get("frame_s")
    return Pictures(dict.fromkeys(named, b""), tuple(there), frame_s if isinstance(frame_s, float) else None)


def _texts(said: Any) -> list[str]:
    """The texts of a list that a process left; it judged a stranger's film, so it may have left anything."""
    return [one for one in said if isinstance(one, str)] if isinstance(said, list) else []


def pictures_of_job(job: Job) -> Pictures:
    """The pictures of a job.  Raises: Refusal 404 where they were removed."""
    shown = list_pictures(job)
    return Pictures({name: kept_file(job, name) for name in shown.files}, shown.plots, shown.frame_s)


def kept_file(job: Job, name: str) -> bytes:
    """A file that a job's process left; name: one of ours.  Raises: Refusal 404 where there is none, or a huge one."""
    try:
        with os.fdopen(os.open(job.folder / name, os.O_RDONLY | os.O_NOFOLLOW), "rb") as stream:
            content = stream.read(KEPT_BYTES + 1)
    except OSError as error:
        raise Refusal(404, "no_report", "There is no such picture or report, or it was removed already.") from error
    if len(content) > KEPT_BYTES:
        raise Refusal(404, "no_report", "This picture or report is larger than any of ours; the film may be damaged.")
    return content
