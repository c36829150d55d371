"""The version of the sources that a row depends on: a hash of the modules that a module imports, directly or not."""

from __future__ import annotations

import ast
import hashlib
from collections.abc import Iterator
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[4]
#: Where modules of the project are, in a checkout.
FOLDERS = ("src", "studio/src", "lab/src", "benchmarks")
#: Files next to a module that it may read.
DATA = (".c", ".h", ".csv", ".json", ".toml", ".npz")


@cache
def version_of(*sources: str) -> str:
    """Hash of the content of these modules and paths, of all modules that they import, and of the data next to those.

    Convention: imports count wherever they are in a file, also within functions and for types; a package's `__init__`
        counts where it is imported by name, not as the parent of a module.  A path has a slash in it.
    """
    files = _closure(sources)
    for folder in {place for path in files if "src" in path.parts for place in (path.parent, path.parent / "data")}:
        files |= {path for path in folder.glob("*") if path.suffix in DATA}
    for name in sources:
        if "/" in name:
            files |= {path for path in (ROOT / name, *(ROOT / name).rglob("*")) if path.is_file()}
    digest = hashlib.sha256()
    for path in sorted(files):
        digest.update(path.relative_to(ROOT).as_posix().encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()[:12]


def _closure(modules: tuple[str, ...]) -> set[Path]:
    """The files of modules and of all that they import."""
    found: set[Path] = set()
    todo = [path for name in modules if "/" not in name and (path := _file_of(name))]
    while todo:
        if (path := todo.pop()) not in found:
            found.add(path)
            todo += [other for name in _imports(path) if (other := _file_of(name))]
    return found


@cache
def _file_of(name: str) -> Path | None:
    """The file of a module of the project; None for others."""
    for folder in FOLDERS:
        place = ROOT / folder / name.replace(".", "/")
        for path in (place.with_name(f"{place.name}.py"), place / "__init__.py"):
            if path.is_file():
                return path
    return None


@cache
def _imports(path: Path) -> tuple[str, ...]:
    """Names of what a file imports; of `from a import b` both a and a.b."""
    return tuple(_names(ast.parse(path.read_bytes())))


def _names(tree: ast.AST) -> Iterator[str]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (one.name for one in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield node.module
            yield from (f"{node.module}.{one.name}" for one in node.names)
