"""The work of a film's own process: a film in, a verdict out.  Nothing here knows of requests or pages.

Loading this module loads all packages of the work.  A process that has loaded it is forked for each job, so that the
job can begin at once (`child.py`).  The process may be in a stranger's hands, so it never gets the registry.
"""

from __future__ import annotations

import os

import av  # noqa: F401 - loaded ahead
import matplotlib.backends.backend_svg
import matplotlib.figure  # noqa: F401 - loaded ahead

import moireid.verifier.session.capture
import moireid.verifier.session.identify  # noqa: F401 - loaded ahead
from moireid.lenticule import know_law
from moireid.sandbox.child import Talk
from moireid_studio.jobs.task import Task


def judge(talk: Talk) -> None:
    """Do a task in this process, which then ends."""
    task: Task | None = talk.next()
    if task is None or task.order is None:
        return
    os.chdir(task.folder)
    for law in task.laws:
        know_law(*law)
    for part in task.order(talk.progress):
        talk.send(part)
