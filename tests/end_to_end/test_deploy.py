"""The files by which moireid is deployed.  Each test names the wrong file it catches."""

from __future__ import annotations

import json
import re
import subprocess
from importlib import resources
from pathlib import Path
from typing import Any

import dask
import jsonschema
import pytest
import yaml
from click.testing import CliRunner
from distributed import Security

from moireid.cli.main import moireid
from moireid.errors import SpecError
from moireid.scheduler import scheduler_client

ROOT = Path(__file__).parents[2]
DEPLOY = ROOT / "deploy"


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
    assert len(found) == 3
    for words in ("serve", "registry init", "registry signer"):
        start = ["moireid", *words.split()]
        (command,) = [command for command in found if command[: len(start)] == start]
        output = CliRunner().invoke(moireid, [*start[1:], "--help"]).stdout
        assert options_of(command) <= set(re.findall(r"--[a-z-]+", output))


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
