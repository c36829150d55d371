"""Optional packages: the sentence for one that is missing, with the command that adds it to this very installation."""

from __future__ import annotations

import importlib.metadata
import json
import shlex
import sys
import tomllib
from pathlib import Path
from typing import Any

from moireid.errors import MissingExtraError


def missing_extra(what: str, package: str, extra: str) -> MissingExtraError:
    """The error to raise where `what` (a sentence's subject) needs a package of an extra that is not installed."""
    return MissingExtraError(
        f"{what} needs {package}, which is not installed; install it with: {install_command(extra)}",
        package=package,
        extra=extra,
    )


def install_command(extra: str) -> str:
    """The command that adds an extra to where this program runs, from where the program came.

    `uv tool install` forgets the extras that it is not given anew, and such a place has no pip.
    """
    receipt = Path(sys.prefix, "uv-receipt.toml")
    if receipt.is_file():
        return f"uv tool install {shlex.quote(_requirement({extra, *_extras_of(receipt)}))}"
    editable = _origin().get("dir_info", {}).get("editable", False)
    return f"pip install {'-e ' if editable else ''}{shlex.quote(_requirement({extra}, editable=editable))}"


def _requirement(extras: set[str], *, editable: bool = False) -> str:
    """What to install, for pip and uv: from the same file, folder or repository as this installation; else by name."""
    origin, named = _origin(), f"[{','.join(sorted(extras))}]"
    url = str(origin.get("url", ""))
    if editable:
        return url.removeprefix("file://") + named
    if "vcs_info" in origin:
        url = f"{origin['vcs_info']['vcs']}+{url}@{origin['vcs_info']['commit_id']}"
    return f"moireid{named}" + (f" @ {url}" if url else "")


def _origin() -> dict[str, Any]:
    """Where this installation came from (PEP 610); empty where it came from an index by its name."""
    try:
        return dict(json.loads(importlib.metadata.distribution("moireid").read_text("direct_url.json") or "{}"))
    except (importlib.metadata.PackageNotFoundError, json.JSONDecodeError):
        return {}


def _extras_of(receipt: Path) -> set[str]:
    """The extras with which uv installed the program."""
    wanted = tomllib.loads(receipt.read_text(encoding="utf-8")).get("tool", {}).get("requirements", [])
    return {extra for one in wanted if one.get("name") == "moireid" for extra in one.get("extras", [])}
