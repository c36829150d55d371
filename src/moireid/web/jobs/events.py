"""A job's progress as server-sent events."""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator

from moireid.web.jobs.queue import Job

#: Time between two looks at a job that somebody watches.
LOOK_S = 0.2


async def events_of(job: Job) -> AsyncIterator[str]:
    """`progress` with state and frames as they change, and one `end` once the job is over.

    Source: "Server-sent events" of the HTML standard.
    """
    last = ""
    while True:
        over = job.over
        said = json.dumps({"state": job.state, "read": job.frames[0], "expected": job.frames[1]})
        if over or said != last:
            yield f"event: {'end' if over else 'progress'}\ndata: {said}\n\n"
            last = said
        if over:
            return
        await asyncio.sleep(LOOK_S)
