"""What all routes share: the settings, the open registry, the tokens, and the jobs."""

from __future__ import annotations

import fcntl
import logging
import threading
import time
from collections import Counter
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

from starlette.requests import HTTPConnection

from moireid.errors import MoireIdError, RegistryError, SpecError
from moireid.provenance import Standing
from moireid.registry import Audit, Record, Registry, default_url, open_registry
from moireid.registry.checkpoints.checkpoint import Checkpoint, read_checkpoint
from moireid.registry.engine import read_url
from moireid.registry.keys import keys_folder
from moireid.registry.seen import seen_path
from moireid_studio.auth.tokens import Tokens
from moireid_studio.http.metrics import Metrics
from moireid_studio.jobs.claims import prepared
from moireid_studio.jobs.cluster import Cluster
from moireid_studio.jobs.queue import Jobs
from moireid_studio.jobs.workers import Doer
from moireid_studio.links import Links
from moireid_studio.problems import Refusal, plain
from moireid_studio.settings import Settings
from moireid_studio.store.database import database_of
from moireid_studio.store.ledger import Ledger

if TYPE_CHECKING:
    from moireid.cli.witness_options import WitnessCheck

#: Anyone may ask whether the studio is ready, and no one shall keep its database busy by that.
NEEDS_S = 1.0


class Studio:
    """One running studio; a route gets it by `studio_of(request)`."""

    def __init__(self, settings: Settings) -> None:
        """The default registry is made where it is absent; one that is named must be there.

        Raises: RegistryError where the registry is absent, was put back or is another authority's, or the studio's
            folder cannot be used; SpecError where another studio uses that folder, or no scheduler answers.
        """
        self.settings, self._auditing, self.metrics = settings, threading.Lock(), Metrics()
        self._needs: tuple[float, dict[str, bool]] = (-NEEDS_S, {})
        #: Live checks that go on, by whether a link began them and whose token it is of.
        self.live_sessions = Counter[tuple[bool, str]]()
        with ExitStack() as undo:
            self.registry: Registry = undo.enter_context(
                open_registry(settings.registry_url, create=settings.registry_url is None)
            )
            self.registry.standing(settings.trust)
            self.tokens = Tokens(settings.data, settings.state)
            undo.callback(self.tokens.close)
            hold_folder(settings.data, undo)
            self.links = Links(settings.data, settings.state)
            undo.callback(self.links.close)
            self.jobs = self._jobs(undo)
            self._open = undo.pop_all()

    def _jobs(self, undo: ExitStack) -> Jobs:
        settings, folder = self.settings, (self.settings.data / "jobs").absolute()
        database = database_of(settings.data, "jobs.sqlite3", None, log=True)
        undo.callback(database.close)
        cluster = None
        if settings.scheduler is not None:
            cluster = Cluster(settings.scheduler, settings.worker_url, unsealed=settings.unsealed)
            undo.callback(cluster.close)
        doer = Doer(
            Ledger(database, folder),
            settings.limits,
            lambda job: prepared(job, self.registry, settings.trust, lambda: self.for_children),
            registry=self.registry,
            metrics=self.metrics,
            cluster=cluster,
        )
        return Jobs(folder, doer)

    @property
    def for_children(self) -> dict[str, str | None]:
        """The registry's URL, its keys, and what was seen of it, for processes that issue badges.

        These work in another folder, and may be older than all that.
        """
        url = read_url(self.settings.registry_url or default_url()).render_as_string(hide_password=False)
        places = {"keys": keys_folder(), "seen": seen_path()}
        found = {name: str(place) if place else None for name, place in places.items()}
        return {"registry_url": url} | found

    def needs(self) -> dict[str, bool]:
        """Of each thing that the studio needs for new work, whether it is there; looked at once a second at most."""
        if time.monotonic() - self._needs[0] > NEEDS_S:
            self._needs = time.monotonic(), self._look()
        return self._needs[1]

    def _look(self) -> dict[str, bool]:
        needs = self.jobs.check()
        for name, ask in (("registry", self.registry.count), ("database", self.tokens.all)):
            try:
                ask()
                needs[name] = True
            except RegistryError:
                needs[name] = False
        return needs

    def standing(self) -> Standing:
        """The registry's authority and head now.  Raises: Refusal 503 where it was put back while the studio runs."""
        try:
            return self.registry.standing(self.settings.trust)
        except RegistryError as error:
            text = self.sentence(error)
            raise Refusal(503, "registry", f"{text[:1].upper()}{text[1:]}.") from error

    def record(self, badge_id: str) -> Record:
        """The record of a badge.  Raises: Refusal 404 where there is none."""
        if (found := self.registry.by_id(badge_id)) is None:
            raise Refusal(404, "no_badge", "No badge of this id is in the registry.")
        return found

    def sentence(self, error: Exception | str) -> str:
        """An error's sentence without the registry's place, which is not for those who come from outside, and without
        the words of the command line.
        """
        shown = self.registry.shown_url
        text = " ".join(str(error).split()).replace(f"registry {shown}", "the registry").replace(shown, "the registry")
        return plain(text)

    def audit(self) -> Audit:
        """Audit the registry; only one audit runs at a time, because each reads everything.

        Raises: Refusal 503 where another audit runs.
        """
        if not self._auditing.acquire(blocking=False):
            raise Refusal(503, "busy", "Another audit runs; try again when it is done.", headers={"Retry-After": "30"})
        try:
            check = self.settings.witness_check
            witnesses, since = ((), []) if check is None else (check.witnesses, self._witnessed(check))
            return self.registry.audit(None, since, witnesses)
        finally:
            self._auditing.release()

    def _witnessed(self, check: WitnessCheck) -> list[Checkpoint]:
        """The checkpoint as it is now, as those who run the registry renew it; none where it cannot be read."""
        try:
            return [read_checkpoint(check.source)] if check.source is not None else []
        except MoireIdError as error:
            # The audit reports that no witness has signed, and all else that it finds.
            logging.getLogger(__name__).error("%s", error)
            return []

    def start(self) -> None:
        """Begin to work.  Raises: RegistryError where the database cannot be used."""
        self.jobs.start()

    def stop(self) -> None:
        """End the work; what is not done waits for the next studio that starts."""
        self.jobs.stop()

    def close(self) -> None:
        """Close what is open."""
        self._open.close()


def studio_of(connection: HTTPConnection) -> Studio:
    """The studio that a request or a WebSocket has reached."""
    studio: Studio = connection.app.state.studio
    return studio


def hold_folder(folder: Path, undo: ExitStack) -> None:
    """Hold a folder's lock, which the system releases however this process ends.

    Without the lock, another process would remove the films here as leftovers of its own.

    Raises: RegistryError where the folder cannot be used; SpecError where another one holds it.
    """
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        lock = undo.enter_context((folder / "lock").open("a"))
    except OSError as error:
        raise RegistryError(f"{folder} cannot be used ({error.strerror}); give another (data)") from error
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        raise SpecError(f"another studio runs with the folder {folder}; stop it, or give another (data)") from error
