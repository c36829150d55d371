"""Optional packages: the sentence for one that is missing, with the command that adds it to this very installation."""

from __future__ import annotations

import json
import shlex
import sys
from pathlib import Path
from typing import Any

from moireid.errors import MissingExtraError

#: The folder of each distribution in the project's repository, besides moireid's own, which is at its root.
FOLDERS = {"moireid-studio": "studio", "moireid-lab": "lab"}


def missing_extra(what: str, package: str, extra: str, distribution: str = "moireid") -> MissingExtraError:
    """The error to raise where `what` (a sentence's subject) needs a package that is not installed.

    Parameters: extra: of `distribution`, such as "cad"; "" for a package that the distribution itself needs.
    """
    return MissingExtraError(
        f"{what} needs {package}, which is not installed; install it with: {install_command(extra, distribution)}",
        package=package,
        extra=extra,
    )


def install_command(extra: str = "", distribution: str = "moireid") -> str:
    """The command that adds a distribution of the project, or an extra of one, to where this program runs.

    It names the place from which the program came.  `uv tool install` forgets what it is not given anew, and such a
    place has no pip.
    """
    receipt = Path(sys.prefix, "uv-receipt.toml")
    if receipt.is_file():
        wanted = _extras_by_distribution(receipt)
        wanted.setdefault(distribution, set()).update({extra} - {""})
        first = _requirement("moireid", wanted.pop("moireid", set()))
        others = [f" --with {shlex.quote(_requirement(name, extras))}" for name, extras in sorted(wanted.items())]
        return f"uv tool install {shlex.quote(first)}{''.join(others)}"
    editable = _origin().get("dir_info", {}).get("editable", False)
    return f"pip install {'-e ' if editable else ''}{shlex.quote(_requirement(distribution, {extra} - {''}, editable))}"


def _requirement(distribution: str, extras: set[str], editable: bool = False) -> str:
    """What to install, for pip and uv: from the same file, folder or repository as this installation; else by name."""
    origin, named = _origin(), f"[{','.join(sorted(extras))}]" if extras else ""
    url, folder = str(origin.get("url", "")), FOLDERS.get(distribution, "")
    if editable:
        return "/".join(filter(None, (url.removeprefix("file://"), folder))) + named
    if "vcs_info" in origin:
        url = f"{origin['vcs_info']['vcs']}+{url}@{origin['vcs_info']['commit_id']}"
        url += f"#subdirectory={folder}" if folder else ""
    elif url.endswith(".whl"):
        # The wheels of one release are in one folder.  Those of the other distributions are for every machine.
        place, _, name = url.rpartition("/")
        if distribution != "moireid":
            version = name.split("-")[1]
            name = f"{distribution.replace('-', '_')}-{version}-py3-none-any.whl"
        url = f"{place}/{name}"
    elif folder:
        url = f"{url}/{folder}" if url else ""
    return f"{distribution}{named}" + (f" @ {url}" if url else "")


def _origin() -> dict[str, Any]:
    """Where this installation came from (PEP 610); empty where it came from an index by its name."""
    # Half as long to import as all else that a command's help needs.
    import importlib.metadata

    try:
        return dict(json.loads(importlib.metadata.distribution("moireid").read_text("direct_url.json") or "{}"))
    except (importlib.metadata.PackageNotFoundError, json.JSONDecodeError):
        return {}


def _extras_by_distribution(receipt: Path) -> dict[str, set[str]]:
    """The extras with which uv installed each distribution of the project in this place."""
    import tomllib

    wanted = tomllib.loads(receipt.read_text(encoding="utf-8")).get("tool", {}).get("requirements", [])
    ours = [one for one in wanted if one.get("name") in ("moireid", *FOLDERS)]
    return {one["name"]: set(one.get("extras", [])) for one in ours}
