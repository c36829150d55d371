"""What the compose file must say so that a container that is taken over gains little.  Each rule has a name and a
weakened service that it must find; so each test catches the rule that holds whatever the file says.

Source: the level "restricted" of Kubernetes' Pod Security Standards, and the NSA's Kubernetes hardening guide.
"""

from __future__ import annotations

import copy
import json
import os
import re
import subprocess
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
import yaml

from kit.places import ROOT
from moireid.sandbox.seccomp import library

DEPLOY = ROOT / "deploy"
Document = dict[str, Any]


@dataclass
class Unit:
    """A container as the file describes it; user, group: None where they are not fixed, or root's."""

    name: str
    image: str
    user: int | None
    group: int | None
    read_only: bool
    dropped: set[str]
    added: set[str]
    gains: bool
    seccomp: str | None
    limits: set[str]
    mounts: dict[str, bool]
    environment: set[str]
    of_host: bool
    networks: set[str]


def compose_units(compose: Document) -> dict[str, Unit]:
    """The services of a compose file; mounts: whether each volume is read-only."""
    found = {}
    for name, one in compose["services"].items():
        ids = [int(part) for part in str(one.get("user", "0")).split(":")]
        limits = set(one.get("deploy", {}).get("resources", {}).get("limits", {}))
        options = [str(option) for option in one.get("security_opt", ())]
        seccomp = next((option.partition(":")[2] for option in options if option.startswith("seccomp")), "default")
        volumes = [volume.split(":") for volume in one.get("volumes", ())]
        host = one.get("privileged", False) or bool({"pid", "ipc", "userns_mode", "devices"} & set(one))
        host |= one.get("network_mode") == "host" or any(volume[0].startswith("/") and volume[1:] for volume in volumes)
        found[name] = Unit(
            name,
            one["image"],
            ids[0] or None,
            ids[1] if ids[1:] and ids[1] else None,
            one.get("read_only") is True,
            set(one.get("cap_drop", ())),
            set(one.get("cap_add", ())),
            "no-new-privileges:true" not in options,
            None if seccomp == "unconfined" else seccomp,
            limits,
            {volume[0]: volume[-1] == "ro" for volume in volumes},
            set(one.get("environment", ())),
            bool(host),
            set(one.get("networks", () if one.get("network_mode") == "none" else ("default",))),
        )
    return found


#: A digest, or a variable without which compose refuses.
PINNED = re.compile(r"\S+@sha256:[0-9a-f]{64}|\$\{[A-Z]+_IMAGE:\?run pin\.sh\}")
OURS = ("signer", "init", "studio", "certificate", "scheduler", "worker")
#: Each rule by its name.  A unit for which it does not hold is a fault.
RULES: dict[str, Callable[[Unit], bool]] = {
    "no root": lambda unit: unit.user is not None and unit.group is not None,
    "read-only root": lambda unit: unit.read_only,
    "capabilities dropped": lambda unit: unit.dropped == {"ALL"} and unit.added <= {"NET_BIND_SERVICE"},
    "no capability for ours": lambda unit: unit.name not in OURS or not unit.added,
    "no new privileges": lambda unit: not unit.gains,
    "seccomp": lambda unit: unit.seccomp is not None and (unit.name not in OURS or unit.seccomp.endswith(".json")),
    "limits": lambda unit: len(unit.limits & {"memory", "cpu", "cpus"}) == 2 and len(unit.limits) == 3,
    "nothing of the host": lambda unit: not unit.of_host,
    "image by digest": lambda unit: PINNED.fullmatch(unit.image) is not None,
    "key for the signer alone": lambda unit: ("keys" in unit.mounts) is (unit.name == "signer"),
    "no secret for the signer": lambda unit: unit.name != "signer" or unit.environment == {"MOIREID_KEYS"},
    "socket": lambda unit: unit.name not in ("studio", "init") or unit.mounts.get("socket") is True,
    "asks the signer": lambda unit: unit.name not in ("studio", "init") or "MOIREID_SIGNER" in unit.environment,
    "no signer and no password for a worker": lambda unit: (
        unit.name not in ("worker", "scheduler")
        or not ({"socket"} & set(unit.mounts) | {"PGPASSWORD"} & unit.environment)
    ),
    "certificate for the cluster alone": lambda unit: (
        ("cluster" in unit.mounts) is (unit.name in ("certificate", "studio", "scheduler", "worker"))
    ),
    "signer has a user of its own": lambda unit: (
        unit.name not in OURS or (unit.user == 10002) is (unit.name == "signer")
    ),
    "signer without network": lambda unit: unit.name != "signer" or not unit.networks,
}


def faults(units: dict[str, Unit]) -> set[tuple[str, str]]:
    return {(name, rule) for name, unit in units.items() for rule, holds in RULES.items() if not holds(unit)}


@pytest.fixture
def compose() -> Document:
    return dict(yaml.safe_load((DEPLOY / "compose.yaml").read_text(encoding="utf-8")))


def test_the_shipped_file_keeps_every_rule(compose: Document) -> None:
    """Catches: a service that was added, or an option that was lost, by which a container may do more than it needs."""
    assert set(compose_units(compose)) == {"proxy", "database", *OURS}
    assert faults(compose_units(compose)) == set()


#: A weakened service of the compose file: of whom, what is changed, and the rule that must find it.
WEAK_SERVICES: dict[str, tuple[str, Callable[[Document], object]]] = {
    "no root": ("studio", lambda one: one.pop("user")),
    "read-only root": ("worker", lambda one: one.pop("read_only")),
    "capabilities dropped": ("proxy", lambda one: one.update(cap_drop=["NET_RAW"])),
    "no capability for ours": ("studio", lambda one: one.update(cap_add=["NET_BIND_SERVICE"])),
    "no new privileges": ("worker", lambda one: one.update(security_opt=["seccomp:./seccomp.json"])),
    "seccomp": ("worker", lambda one: one.update(security_opt=["no-new-privileges:true", "seccomp:unconfined"])),
    "limits": ("worker", lambda one: one["deploy"]["resources"]["limits"].pop("memory")),
    "nothing of the host": ("studio", lambda one: one["volumes"].append("/var/run/docker.sock:/s")),
    "image by digest": ("database", lambda one: one.update(image="docker.io/library/postgres:17")),
    "key for the signer alone": ("studio", lambda one: one["volumes"].append("keys:/keys")),
    "no secret for the signer": ("signer", lambda one: one["environment"].update(PGPASSWORD="x")),
    "socket": ("studio", lambda one: one["volumes"].remove("socket:/run/moireid:ro")),
    "asks the signer": ("studio", lambda one: one["environment"].pop("MOIREID_SIGNER")),
    "no signer and no password for a worker": ("worker", lambda one: one["environment"].update(PGPASSWORD="x")),
    "certificate for the cluster alone": ("proxy", lambda one: one["volumes"].append("cluster:/cluster:ro")),
    "signer has a user of its own": ("studio", lambda one: one.update(user="10002:10002")),
    "signer without network": ("signer", lambda one: (one.pop("network_mode"), one.update(networks=["back"]))),
}


@pytest.mark.parametrize("rule", WEAK_SERVICES)
def test_a_weakened_service_is_found(compose: Document, rule: str) -> None:
    """Catches: a rule that holds for every compose file."""
    name, weaken = WEAK_SERVICES[rule]
    # Services share parts of the file, which a change must not reach.
    compose["services"] = {key: copy.deepcopy(one) for key, one in compose["services"].items()}
    weaken(compose["services"][name])
    assert (name, rule) in faults(compose_units(compose))


def test_each_rule_is_tried() -> None:
    """Catches: a rule that was added without a service that breaks it."""
    assert set(WEAK_SERVICES) == set(RULES)


def test_services_reach_what_they_need_and_nothing_else(compose: Document) -> None:
    """Catches: a database or a worker that the world reaches, or from which it is reached."""
    inside = {name for name, network in compose["networks"].items() if network.get("internal")}
    networks = {name: unit.networks for name, unit in compose_units(compose).items()}
    assert [name for name, own in networks.items() if not own <= inside] == ["proxy"]
    assert networks["studio"] & networks["proxy"] == {"front"} and not networks["database"] & networks["proxy"]
    assert networks["worker"] == networks["scheduler"] == {"cluster"} <= networks["studio"]
    assert [name for name, one in compose["services"].items() if "ports" in one] == ["proxy"]


def test_the_filter_lets_a_film_s_process_seal_itself_and_little_else() -> None:
    """Catches: a filter with which nothing seals, so that `serve` refuses; one that allows ways out of a container."""
    profile = json.loads((DEPLOY / "seccomp.json").read_text(encoding="utf-8"))
    allowed = [rule for rule in profile["syscalls"] if rule["action"] == "SCMP_ACT_ALLOW"]
    names = {name for rule in allowed for name in rule["names"]}
    assert profile["defaultAction"] == "SCMP_ACT_ERRNO"
    assert {"seccomp", "prctl", "landlock_create_ruleset", "landlock_add_rule", "landlock_restrict_self"} <= names
    closed = (
        "mount umount2 pivot_root setns unshare clone3 ptrace process_vm_readv process_vm_writev bpf keyctl add_key"
    )
    closed += " perf_event_open userfaultfd io_uring_setup open_by_handle_at init_module kexec_load personality mknod"
    assert not names & set(closed.split())
    assert all("args" in rule for rule in allowed if {"clone", "socket"} & set(rule["names"]))
    for name in names:
        assert library().seccomp_syscall_resolve_name(name.encode()) != -1, name


ENGINE = """#!/bin/sh
[ "$1 $3" = "pull moireid" ] && exit 1
[ "$1" = pull ] && exit 0
case "$5" in
    moireid) echo 1111111111111111111111111111111111111111111111111111111111111111 ;;
    *) echo "${5%:*}@sha256:2222222222222222222222222222222222222222222222222222222222222222" ;;
esac
"""


@pytest.mark.parametrize("image", ["moireid", "example.org/m:1"])
def test_pinning_leaves_no_tag(tmp_path: Path, image: str, compose: Document) -> None:
    """Catches: an image that is still run by a tag once pin.sh has run."""
    (tmp_path / "pin.sh").write_text((DEPLOY / "pin.sh").read_text(encoding="utf-8"))
    (tmp_path / "engine").write_text(ENGINE)
    (tmp_path / "engine").chmod(0o755)
    environment = os.environ | {"ENGINE": str(tmp_path / "engine")}
    subprocess.run(["sh", tmp_path / "pin.sh", image], env=environment, check=True, capture_output=True)
    pinned = dict(line.split("=", 1) for line in (tmp_path / "images.env").read_text().splitlines())
    wanted = {str(one["image"]).partition("{")[2].partition(":")[0] for one in compose["services"].values()}
    assert set(pinned) == wanted
    assert all(re.fullmatch(r"(\S+@)?sha256:[0-9a-f]{64}", one) for one in pinned.values())
