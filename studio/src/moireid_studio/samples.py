"""Films to try, which come with moireid: a true one and a forged one, of a badge that belongs to no one."""

from __future__ import annotations

import hashlib
from importlib import resources
from typing import Literal, get_args

from moireid_studio.auth.guard import Visitor
from moireid_studio.checks import submit_claim
from moireid_studio.jobs.queue import Job
from moireid_studio.studio import Studio

Sample = Literal["true", "forged"]
SAMPLES: tuple[Sample, ...] = get_args(Sample)


def start_sample(studio: Studio, visitor: Visitor, which: Sample) -> Job:
    """Let a sample be judged like any film that was sent.  Raises: Refusal 503 where too many films wait."""
    folder = resources.files("moireid_studio").joinpath("samples")
    film, badge = folder.joinpath(f"{which}.mp4").read_bytes(), folder.joinpath("badge.json").read_text("utf-8")
    with studio.jobs.receiving("verify", visitor.id) as job:
        (job.folder / "film.mp4").write_bytes(film)
        job.film_name, job.film_sha256 = f"sample, {which}.mp4", hashlib.sha256(film).hexdigest()
        submit_claim(studio, visitor, job, job.folder / "film.mp4", {"badge": badge}, report=True)
    return job
