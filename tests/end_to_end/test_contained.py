"""Signer, studio, scheduler and worker as the compose file starts them: its commands and users, each with read-only
mounts, no capabilities and the shipped filter of calls (`kit.contained`), with a real PostgreSQL server.

Not checked here, for want of a container engine: networks, limits of cgroups, and the owners that volumes get.
"""

from __future__ import annotations

import grp
import os
import re
import shutil
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

import httpx
import pytest
import yaml
from sqlalchemy.engine import make_url

from kit.contained import contained
from kit.places import FILMS, ROOT
from kit.registries import badge_of, running_server
from kit.webbing import film_form, tiny_film

pytestmark = pytest.mark.slow
SERVICES = yaml.safe_load((ROOT / "deploy" / "compose.yaml").read_text(encoding="utf-8"))["services"]
#: A group that every system has, in the place of the image's.
GROUP = grp.getgrgid(os.stat("/var/mail").st_gid) if Path("/var/mail").exists() else grp.getgrnam("mail")
PORT, SCHEDULER = "18473", "18474"


@dataclass
class Containers:
    """The services of the compose file, with this machine's places in the place of volumes and hosts."""

    folder: Path
    database: str
    stack: ExitStack

    def __post_init__(self) -> None:
        for name in ("keys", "socket", "cluster", "dask", *(f"{service} data" for service in SERVICES)):
            folder = self.folder / name.replace(" ", "-")
            folder.mkdir()
            os.chown(folder, int(self.user("signer" if name in ("keys", "socket") else "studio")[0]), GROUP.gr_gid)
            folder.chmod(0o700 if name == "keys" else 0o770)
        settings = (ROOT / "deploy" / "dask.yaml").read_text(encoding="utf-8")
        (self.folder / "dask" / "dask.yaml").write_text(settings.replace("/cluster", str(self.folder / "cluster")))
        (self.folder / "dask").chmod(0o755)

    def user(self, service: str) -> list[str]:
        return str(SERVICES[service]["user"]).split(":")

    def run(self, service: str, *command: str) -> subprocess.Popen[str]:
        """A service by its own command, or by another one."""
        own = self.folder / f"{service}-data"
        places = {
            "postgresql+psycopg://moireid@database/moireid": self.database,
            "${SITE:-localhost}": "localhost",
            "/run/moireid": str(self.folder / "socket"),
            "--host=0.0.0.0": "--host=127.0.0.1",
            "tls://scheduler:8786": f"tls://127.0.0.1:{SCHEDULER}",
            "8786": SCHEDULER,
            "http://studio": "http://127.0.0.1",
            "8000": PORT,
            "/data": str(own),
            "/cluster": str(self.folder / "cluster"),
            "/keys": str(self.folder / "keys"),
        }

        def here(word: str) -> str:
            for there, place in places.items():
                word = word.replace(there, place)
            return GROUP.gr_name if word == "moireid" else word

        words = command or SERVICES[service]["command"]
        program = str(Path(sys.executable).parent / words[0]) if words[0] in ("moireid", "dask") else words[0]
        mounted = {volume.split(":")[0]: volume for volume in SERVICES[service]["volumes"]}
        folders = {name: self.folder / name for name in ("keys", "socket", "cluster")}
        writable = [path for name, path in folders.items() if name in mounted and not mounted[name].endswith(":ro")]
        environment = {name: here(str(value)) for name, value in SERVICES[service].get("environment", {}).items()}
        environment.pop("PGPASSWORD", None)
        environment |= {
            "TMPDIR": str(own),
            "MPLCONFIGDIR": str(own),
            "HOME": "/nowhere",
            "DASK_CONFIG": str(self.folder / "dask"),
        }
        user, group = self.user(service)
        # The studio's group owns the socket; here it is one that this system has.
        ours = {"10001": GROUP.gr_gid}
        return contained(
            [program, *map(here, words[1:])],
            user=int(user),
            group=ours.get(group, int(group)),
            groups=[ours.get(one, int(one)) for one in SERVICES[service].get("group_add", ())],
            writable=[*writable, own],
            hidden=[path for name, path in folders.items() if name not in mounted],
            **environment,
        )

    def start(self, service: str) -> subprocess.Popen[str]:
        """A service that goes on until the test ends."""
        process = self.run(service)
        self.stack.callback(process.wait)
        self.stack.callback(process.terminate)
        return process

    def output(self, service: str, *command: str, code: int | None = 0) -> str:
        """What a command says in a service's container; it must end with that code, None for any but 0."""
        process = self.run(service, *command)
        said = process.communicate(timeout=120)[0]
        assert process.returncode == code if code is not None else process.returncode, said
        return said


def until(holds: Callable[[], bool], process: subprocess.Popen[str]) -> None:
    last = time.monotonic() + 90
    while not holds():
        assert process.poll() is None and time.monotonic() < last, process.communicate(timeout=5)[0]
        time.sleep(0.2)


@pytest.fixture(scope="module")
def containers() -> Iterator[Containers]:
    with ExitStack() as stack:
        server = stack.enter_context(running_server())
        url = server.fresh()
        # Users of the containers reach the server's socket, and no more of its folder.
        Path(str(make_url(url).query["host"])).chmod(0o711)
        folder = Path(tempfile.mkdtemp(prefix="moireid-contained-"))
        stack.callback(shutil.rmtree, folder, ignore_errors=True)
        folder.chmod(0o755)
        yield Containers(folder, url, stack)


def listens(port: str) -> bool:
    with socket.socket() as one:
        return one.connect_ex(("127.0.0.1", int(port))) == 0


def ready() -> bool:
    try:
        return httpx.get(f"http://127.0.0.1:{PORT}/readyz", timeout=5).status_code == 200
    except httpx.HTTPError:
        return False


def test_the_services_work_together_and_the_studio_never_has_the_key(containers: Containers, tmp_path: Path) -> None:
    """Catches: a filter or a mount with which a film's process cannot seal itself, or a studio not start; a signer that
    the studio does not reach; a key that the studio can read; a root that it can write to.
    """
    signer = containers.start("signer")
    until((containers.folder / "socket" / "signer").is_socket, signer)
    containers.output("init")
    containers.output("certificate")
    scheduler = containers.start("scheduler")
    until(lambda: listens(SCHEDULER), scheduler)
    (key,) = (containers.folder / "keys").iterdir()
    assert (key.stat().st_uid, key.stat().st_mode & 0o777) == (10002, 0o600)
    studio = containers.start("studio")
    until(ready, studio)
    worker = containers.start("worker")
    for service, command in (
        ("studio", ["cat", str(key)]),
        ("studio", ["touch", "/usr/new"]),
        ("studio", ["touch", str(containers.folder / "socket" / "new")]),
        ("worker", ["test", "-e", str(containers.folder / "socket" / "signer")]),
        ("worker", ["unshare", "--user", "true"]),
        ("signer", ["test", "-e", str(containers.folder / "cluster" / "key.pem")]),
    ):
        containers.output(service, *command, code=None)
    given = containers.folder / "studio-data" / "badge.json"
    given.write_text(badge_of("Ada Lovelace").to_json(), encoding="utf-8")
    # A record and its log entry are signed by the signer, as the studio's own user asks.
    said = containers.output("studio", "moireid", "enroll", str(given), "--registry", containers.database)
    assert "Ada Lovelace" in said
    made = containers.output(
        "studio", "moireid", "token", "create", "--role", "verifier", "--state", containers.database
    )
    token = next(line for line in made.splitlines() if re.fullmatch(r"moireid_\S+", line))
    with httpx.Client(base_url=f"http://127.0.0.1:{PORT}", headers={"Authorization": f"Bearer {token}"}) as client:
        form = film_form(tiny_film(FILMS / "genuine_1.0m.mp4", tmp_path / "tiny.mp4"), claim="Ada Lovelace")
        job = client.post("/api/jobs", **form).json()["id"]
        until(lambda: client.get(f"/api/jobs/{job}").json()["state"] in ("done", "failed"), worker)
        ended = client.get(f"/api/jobs/{job}").json()
    assert ended["state"] == "done" and ended["result"]["verdict"] == "inconclusive", ended
    assert sorted(ended["result"]["sealed"]) == ["calls", "files", "no_new_privileges"]
    status = {
        process: Path(f"/proc/{process.pid}/status").read_text(encoding="utf-8")
        for process in (signer, scheduler, studio, worker)
    }
    for text in status.values():
        assert re.search(r"CapBnd:\s+0{16}\n", text) and re.search(r"CapEff:\s+0{16}\n", text)
        assert re.search(r"NoNewPrivs:\s+1\n", text) and re.search(r"Seccomp:\s+2\n", text)
        assert re.search(r"Uid:\s+1000[12]\s", text)
