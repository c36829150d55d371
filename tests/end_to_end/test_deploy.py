"""The files by which moireid is deployed.  Each test names the wrong file it catches."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from importlib import resources
from pathlib import Path
from typing import Any

import dask
import jsonschema
import pytest
import yaml
from click.testing import CliRunner
from distributed import Security

from kit.places import FILMS, ROOT
from moireid.cli.main import moireid
from moireid.errors import SpecError
from moireid.scheduler import scheduler_client

DEPLOY = ROOT / "deploy"
UNDER_FILTER = [sys.executable, "-m", "kit.contained", str(DEPLOY / "seccomp.json")]


def compose() -> dict[str, Any]:
    found: dict[str, Any] = yaml.safe_load((DEPLOY / "compose.yaml").read_text(encoding="utf-8"))
    return found


def options_of(command: list[str]) -> set[str]:
    return {word.partition("=")[0] for word in command if word.startswith("--")}


def test_the_compose_file_is_one() -> None:
    """Catches: a key that no engine knows, or one in the wrong place."""
    schema = json.loads(
        resources.files("check_jsonschema").joinpath("builtin_schemas/vendor/compose-spec.json").read_text()
    )
    jsonschema.Draft202012Validator(schema).validate(compose())
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.Draft202012Validator(schema).validate({"services": {"studio": {"comand": ["x"]}}})


def test_commands_take_the_options_that_they_are_given() -> None:
    """Catches: an option that was renamed, and a studio that does not start after the next release."""
    found = [one["command"] for one in compose()["services"].values() if one.get("command", [""])[0] == "moireid"]
    assert len(found) == 2
    for words in ("serve", "registry init"):
        start = ["moireid", *words.split()]
        (command,) = [command for command in found if command[: len(start)] == start]
        output = CliRunner().invoke(moireid, [*start[1:], "--help"]).stdout
        assert options_of(command) <= set(re.findall(r"--[a-z-]+", output))


def test_the_studio_alone_has_keys_and_the_worker_reaches_none() -> None:
    """Catches: a worker that can read the key, or that has a way to the database."""
    services = compose()["services"]
    mounted = {name: {one.split(":")[0] for one in service.get("volumes", ())} for name, service in services.items()}
    assert [name for name, volumes in mounted.items() if "keys" in volumes] == ["init", "studio"]
    assert services["worker"]["networks"] == ["cluster"]
    ours = [service for service in services.values() if "MOIREID" in service["image"]]
    assert len(ours) == 5 and all(one["read_only"] and one["cap_drop"] == ["ALL"] for one in ours)


@pytest.mark.skipif(sys.platform != "linux", reason="the filter is one of Linux's calls")
def test_a_film_is_read_in_a_sealed_process_under_the_shipped_filter(tmp_path: Path) -> None:
    """Catches: a filter of calls with which a film's process cannot seal itself, or a program not start."""
    words = [*UNDER_FILTER, str(Path(sys.executable).with_name("moireid")), "verify", str(FILMS / "genuine_2.0m.mp4")]
    words += ["--badge", str(FILMS / "badge.json"), "--json"]
    done = subprocess.run(words, cwd=ROOT / "tests", capture_output=True, text=True, check=False)
    assert sorted(json.loads(done.stdout)["sealed"]) == ["calls", "files", "no_new_privileges"], done.stderr
    apart = subprocess.run([*UNDER_FILTER, "unshare", "--user", "true"], cwd=ROOT / "tests", capture_output=True)
    assert apart.returncode != 0


def test_no_one_reaches_the_scheduler_without_the_certificate(tmp_path: Path) -> None:
    """Catches: a certificate that Dask does not take; a scheduler that takes a client, or code, without one."""
    from distributed import LocalCluster

    made = compose()["services"]["certificate"]["command"][-1].replace("/cluster", str(tmp_path))
    subprocess.run(["sh", "-c", made], check=True, capture_output=True)
    settings = yaml.safe_load((DEPLOY / "dask.yaml").read_text(encoding="utf-8").replace("/cluster", str(tmp_path)))
    with (
        dask.config.set({"distributed": dask.config.merge(dask.config.get("distributed"), settings["distributed"])}),
        LocalCluster(1, processes=False, protocol="tls", security=Security(), dashboard_address=None) as cluster,
    ):
        address, none = (
            cluster.scheduler_address,
            {f"distributed.comm.tls.client.{name}": None for name in ("cert", "key")},
        )
        with scheduler_client(address, ("", "")) as client:
            assert address.startswith("tls://") and client.submit(sum, [1, 2]).result(60) == 3
        with dask.config.set(none), pytest.raises(SpecError):
            scheduler_client(address, ("", ""))
