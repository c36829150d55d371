"""The files by which moireid is deployed.  Each test names the wrong file it catches."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from importlib import resources
from pathlib import Path
from typing import Any

import jsonschema
import kubernetes_validate
import pytest
import yaml

ROOT = Path(__file__).parents[2]
DEPLOY = ROOT / "deploy"
#: The oldest release of Kubernetes for which the manifests are checked.
KUBERNETES = "1.30"


def compose() -> dict[str, Any]:
    found: dict[str, Any] = yaml.safe_load((DEPLOY / "compose.yaml").read_text(encoding="utf-8"))
    return found


def manifests() -> list[dict[str, Any]]:
    return list(yaml.safe_load_all((DEPLOY / "kubernetes.yaml").read_text(encoding="utf-8")))


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


@pytest.mark.parametrize("manifest", manifests(), ids=lambda one: f"{one['kind']} {one['metadata']['name']}")
def test_the_manifests_are_such(manifest: dict[str, Any]) -> None:
    """Catches: a field that a cluster refuses, or drops without a word."""
    kubernetes_validate.validate(manifest, KUBERNETES, strict=True)


def commands() -> list[list[str]]:
    services = [one["command"] for one in compose()["services"].values() if "command" in one]
    specs = [one["spec"]["template"]["spec"] for one in manifests() if "template" in one.get("spec", {})]
    return services + [
        one["command"] for spec in specs for one in (*spec.get("initContainers", ()), *spec["containers"])
    ]


def test_commands_take_the_options_that_they_are_given() -> None:
    """Catches: an option that was renamed, and studios that do not start after the next release."""
    found = commands()
    starts = {"serve": 2, "worker": 2, "registry init": 2, "registry signer": 3}
    assert len(found) == sum(starts.values())
    for words, count in starts.items():
        start = ["moireid", *words.split()]
        some = [command for command in found if command[: len(start)] == start]
        program = [
            sys.executable,
            "-c",
            "from moireid.cli.main import main; main()",
            *some[0][1 : len(start)],
            "--help",
        ]
        output = subprocess.run(program, capture_output=True, text=True, check=True).stdout
        assert len(some) == count and all(
            options_of(command) <= set(re.findall(r"--[a-z-]+", output)) for command in some
        )


def test_studios_and_workers_agree_in_both() -> None:
    """Catches: a compose file and manifests that say different things of the same service."""
    studios = [options_of(command) for command in commands() if "serve" in command]
    workers = [options_of(command) for command in commands() if "worker" in command]
    assert studios[0] == studios[1] and workers[0] == workers[1]


def test_the_image_is_built_without_a_network() -> None:
    """Catches: a package that is fetched while the image is built, or one that no lock names."""
    text = (ROOT / "Containerfile").read_text(encoding="utf-8")
    installs = [line for line in text.splitlines() if "pip install" in line]
    assert len(installs) == 2 and all("--no-index" in line for line in installs)
    assert "--require-hashes" in installs[0] and "--no-deps" in installs[1]
    assert not re.search(r"apt-get|curl|wget|ADD https", text)
    ignored = (ROOT / ".containerignore").read_text().split()
    copied = re.findall(r"^COPY (?!--from)(\S+)", text, re.MULTILINE)
    assert {f"!{path}" for path in copied} == set(ignored) - {"*"}
    assert (ROOT / ".dockerignore").read_text() == (ROOT / ".containerignore").read_text()
