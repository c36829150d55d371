"""The pictures of a first badge, and what was measured by hand, handed to rounds of it (`jobs.build_round`).

One round of a build works at a time, and what is sent while it works is refused: two rounds would write one folder.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import msgspec
from fastapi import Request
from fastapi.concurrency import run_in_threadpool

from moireid.bringup.build_folder import BADGE_FILMS, CAMERA_FILM, FILM_SUFFIXES, SHEET_FILM, SHEET_PHOTO, Wish
from moireid_studio.auth.guard import Visitor
from moireid_studio.problems import Refusal
from moireid_studio.store.build_store import FOLDER, Build
from moireid_studio.store.job import Job
from moireid_studio.studio import Studio, studio_of
from moireid_studio.uploads import PHOTOS, UploadKind, receive, sniff

KIND = "build"
#: Of the place for films (`Limits.disk_bytes`), builds may take this share: they are kept for long.
SHARE = 0.25


def _film_suffix(head: bytes) -> str | None:
    suffix = sniff(head)
    return suffix if suffix in FILM_SUFFIXES else None


FILMS = UploadKind(_film_suffix, "This file is none of the films that are taken: MP4, MOV, WebM, MKV or AVI.")
#: What a builder sends, by its well-known name.
SLOTS = {SHEET_PHOTO: PHOTOS, **dict.fromkeys((SHEET_FILM, CAMERA_FILM, *BADGE_FILMS), FILMS)}


def last_job(studio: Studio, build: Build) -> Job | None:
    """The job that reads a build's pictures, or read them last; None where its result was removed since."""
    return studio.jobs.ledger.find(build.note.job) if build.note.job else None


async def receive_media(request: Request, visitor: Visitor, build_id: str, slot: str) -> None:
    """Take a picture or film in, in place of an earlier one, and let it be read.

    Raises
    ------
    Refusal
        Where the build is not the visitor's, works, or has no more room, and as `receive`; nothing changes then.
    """
    studio = studio_of(request)
    build = await run_in_threadpool(studio.builds.find, build_id, visitor.id)
    await run_in_threadpool(_check_free, studio, build)
    taken = await run_in_threadpool(studio.builds.stored_bytes)
    async with studio.jobs.coming(KIND, visitor.id, visitor.role) as job:

        def stored(size: int) -> None:
            studio.jobs.stored(job, size)
            _check_room(studio, taken + size)

        form = await receive(request, job.folder, studio.settings.limits, fields=(), stored=stored, kind=SLOTS[slot])
        if form.video is None:
            raise Refusal(422, "no_film", "No file was sent; choose one.")
        await run_in_threadpool(_start, studio, visitor, job, build_id, media=(slot, form.video))


def start_round(
    studio: Studio, visitor: Visitor, build_id: str, *, wish: Wish | None = None, record: dict[str, Any] | None = None
) -> None:
    """Let a round begin without a new picture.

    Parameters
    ----------
    wish
        What is wished from now on; None: as before.
    record
        As for `build_round.advance_build`.

    Raises
    ------
    Refusal
        Where the build is not the visitor's, or works.
    """
    with studio.jobs.receiving(KIND, visitor.id, visitor.role) as job:
        _start(studio, visitor, job, build_id, wish=wish, record=record)


def remove_build(studio: Studio, build: Build) -> None:
    """Remove a build with all its films, also while they are read."""
    with studio.builds.lock:
        if (job := last_job(studio, build)) is not None:
            studio.jobs.remove(job)
        studio.builds.remove(build)


def _start(
    studio: Studio,
    visitor: Visitor,
    job: Job,
    build_id: str,
    *,
    media: tuple[str, Path] | None = None,
    wish: Wish | None = None,
    record: dict[str, Any] | None = None,
) -> None:
    """Let a job begin that does a round; media: a file in its folder, and its well-known name.  Raises: Refusal."""
    with studio.builds.lock:
        # Another upload may have begun a round meanwhile.
        build = studio.builds.find(build_id, visitor.id)
        _check_free(studio, build)
        if media is not None:
            _place(build, *media)
        note = msgspec.structs.replace(build.note, job=job.id, wish=wish or build.note.wish)
        studio.builds.save(replace(build, note=note))
        order = job.folder / "order"
        order.write_bytes(b"")
        # The film counts for the build from now on.
        job.label, job.bytes = note.wish.name, 0
        studio.jobs.submit(job, order, {"build": build.id, "wish": msgspec.to_builtins(note.wish), "record": record})


def _check_free(studio: Studio, build: Build) -> None:
    if (job := last_job(studio, build)) is not None and not job.over:
        text = "What you sent before is being read just now; send this again when that is done."
        raise Refusal(409, "busy", text, headers={"Retry-After": "30"})


def _check_room(studio: Studio, size: int) -> None:
    if size > SHARE * studio.settings.limits.disk_bytes:
        raise Refusal(503, "disk", "The place for films of builds is full; delete a build that you need no more.")


def _place(build: Build, slot: str, file: Path) -> None:
    """Move a file to its well-known name, in place of an earlier one.  Raises: Refusal 503 where that is impossible."""
    new = build.media / f"{slot}{file.suffix}"
    try:
        # A process may have put anything into its folder.
        if build.media.resolve() != build.work.resolve() / FOLDER:
            raise OSError(0, "its folder is damaged")
        file.replace(new)
        for old in set(build.media.glob(f"{slot}.*")) - {new}:
            old.unlink()
    except OSError as error:
        raise Refusal(503, "disk", f"The film cannot be stored ({error.strerror}); try again later.") from error
