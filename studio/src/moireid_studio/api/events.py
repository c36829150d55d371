"""A job's progress as server-sent events."""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator

from fastapi.concurrency import run_in_threadpool

from moireid_studio.jobs.queue import Job, Jobs

#: Time between two looks at a job that is watched, s.
LOOK_S = 0.2


async def events_of(jobs: Jobs, job: Job) -> AsyncIterator[str]:
    """`progress` with state and frames as they change, and one `end` once the job is over, or was removed.

    Source: "Server-sent events" of the HTML standard.
    """
    last = ""
    while True:
        now = await run_in_threadpool(jobs.ledger.find, job.id)
        over = now is None or now.over
        job = now or job
        said = json.dumps({"state": job.state, "read": job.frames[0], "expected": job.frames[1]})
        if over or said != last:
            yield f"event: {'end' if over else 'progress'}\ndata: {said}\n\n"
            last = said
        if over:
            return
        await asyncio.sleep(LOOK_S)
