"""A verdict as a page: what a job's process found, with what the registry knows.

The registry is asked here, in the server.  The process that decoded the film gets the claimed badge alone, and never
learns whose badge it has read.
"""

from __future__ import annotations

import msgspec

from moireid.registry import holder_of
from moireid.verifier.report.circumstances import Circumstances, read_id
from moireid.verifier.report.report_page import Pictures
from moireid_studio.problems import Refusal
from moireid_studio.store.job import Job
from moireid_studio.studio import Studio


def circumstances_of(studio: Studio, job: Job) -> Circumstances:
    """How a job's check was made, and who holds the badge that it read.  Raises: RegistryError as `holder_of`."""
    read = holder_of(studio.registry, read_id(job.result or {}))
    # The registry's place is not for those who come from outside.
    return Circumstances(
        job.begun, job.film_name or None, job.claim or None, job.barred, read, job.standing or studio.standing()
    )


def list_pictures(job: Job) -> Pictures:
    """The pictures of a job by their names, without their contents."""
    kept = job.kept
    return Pictures(dict.fromkeys(kept.get("files", ()), b""), kept.get("frame_s"))


def pictures_of_job(job: Job) -> Pictures:
    """The pictures of a job.  Raises: Refusal 404 where they were removed."""
    listed = list_pictures(job)
    return msgspec.structs.replace(listed, files={name: kept_file(job, name) for name in listed.files})


def kept_file(job: Job, name: str) -> bytes:
    """A file that was kept with a job.  Raises: Refusal 404 where there is none."""
    try:
        return (job.folder / name).read_bytes()
    except OSError as error:
        raise Refusal(404, "no_report", "There is no such picture or report, or it was removed already.") from error
