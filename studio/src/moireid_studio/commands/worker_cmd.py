"""worker: judge the films of studios on other machines.

The database says which jobs there are, and nothing else hands them out: a worker takes the next one as a studio's own
thread does, and settles it there.  So nothing is lost with a worker, and one that is added need not be announced.
"""

from __future__ import annotations

import signal
import threading
from contextlib import ExitStack
from pathlib import Path

import click

from moireid.cli.common import friendly, registry_option, say, trust_option
from moireid_studio.commands.serve_cmd import (
    check_sealed,
    data_option,
    keep_verdicts_option,
    log_option,
    state_option,
    storage_option,
    unsealed_option,
)

#: How often it is looked whether all threads are at work, s.
CHECK_S = 5.0


@click.command("worker")
@registry_option
@trust_option
@state_option
@storage_option
@click.option(
    "--films",
    type=click.IntRange(1, 256),
    default=1,
    show_default=True,
    metavar="NUMBER",
    help="Films that are judged at a time.",
)
@keep_verdicts_option
@log_option
@unsealed_option
@data_option
@friendly
def worker_command(
    registry_url: str | None,
    trust: str | None,
    state: str | None,
    storage: str | None,
    films: int,
    keep_verdicts: float,
    log: str,
    unsealed: bool,
    data: Path | None,
) -> None:
    """Judge films for studios on other machines, until it is stopped.

    Give it the --registry, --state and --storage of the studios: it takes films from there, one after the other, and
    puts the verdicts there. It needs neither a port nor the registry's keys. Give it their --trust as well, and
    --keep-verdicts 0 where they keep none; how long others are kept, the studios say.
    """
    from moireid.errors import RegistryError, SpecError
    from moireid.registry import open_registry
    from moireid.registry.engine import read_url
    from moireid_studio.http.logs import begin as begin_log
    from moireid_studio.jobs.child import films as film_processes
    from moireid_studio.jobs.claims import prepared
    from moireid_studio.jobs.queue import clear_leftovers
    from moireid_studio.jobs.workers import Doer, Workers
    from moireid_studio.settings import Limits, default_data
    from moireid_studio.store.database import database_of
    from moireid_studio.store.ledger import Ledger
    from moireid_studio.store.storage import storage_of
    from moireid_studio.store.verdict_store import Verdicts
    from moireid_studio.studio import hold_folder

    # A copy of a registry's file would not know of badges that were revoked since.
    here = registry_url is None or read_url(registry_url).get_backend_name() == "sqlite"
    if here or state is None or storage is None:
        raise SpecError(
            "a worker judges films of studios elsewhere; give their --registry and --state on PostgreSQL, and --storage"
        )
    check_sealed(allowed=unsealed)
    folder, limits = (data or default_data()).absolute() / "worker", Limits()
    begin_log(as_json=log == "json")
    with ExitStack() as held:
        hold_folder(folder, "worker", held)
        clear_leftovers(folder, but_jobs=False)
        registry = held.enter_context(open_registry(registry_url, create=False))
        registry.standing(trust)
        database = database_of(folder, "jobs.sqlite3", state)
        held.callback(database.close)
        # How long verdicts are kept is the studios' to say: none is removed here.
        verdicts = Verdicts(folder, 0 if keep_verdicts == 0 else None, state)
        held.callback(verdicts.close)
        # Badges are made where the keys are: by a studio, and by no worker.
        doer = Doer(
            Ledger(database, folder),
            storage_of(storage, folder),
            limits,
            lambda job: prepared(job, registry, trust, dict),
            verdicts.note_job,
            registry=registry,
        )
        workers = Workers(doer)
        film_processes.warm_up()
        stop = threading.Event()
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, lambda *_: stop.set())
        workers.start([("judge",)] * films, tidy=False)
        say(f"judging films, {films} at a time  (stop it with Ctrl-C)")
        while not stop.wait(CHECK_S):
            if not all(thread.is_alive() for thread in workers.threads):
                raise RegistryError("a thread of this worker ended by an error, which its log has; start it again")
        workers.stop()
