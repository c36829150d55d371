"""The files that a row depends on: the project's modules that its process has loaded, and the data next to those.

As with the dependency files of build systems, a row is older once one of them has changed: a new import can only come
through such a change.  Words about the code, which are docstrings and comments, change no row.
"""

from __future__ import annotations

import hashlib
import io
import os
import sys
import tokenize
from collections.abc import Iterable, Sequence
from datetime import UTC, datetime
from functools import cache
from itertools import pairwise
from pathlib import Path

from moireid_lab.bench.part import Asked, Row
from moireid_lab.bench.suites import part_of

ROOT = Path(__file__).parents[4]
#: Where modules of the project are, in a checkout; and those that run cases and change no row.
FOLDERS, RUNNERS = ("src", "studio", "lab", "benchmarks"), ("lab/src/moireid_lab/archive", "src/moireid/sandbox")
#: Files next to a module that it may read.
DATA = (".c", ".h", ".csv", ".json", ".toml", ".npz")

#: What stands before and after a string that is a statement by itself, a docstring.
STATEMENT_BEGINS = (tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT)
STATEMENT_ENDS = (tokenize.NEWLINE, tokenize.COMMENT)


def judged(job: tuple[str, str, Asked, Path]) -> Row:
    """The row of one case, with the files that it depends on; runs in a process of its part."""
    name, case, asked, folder = job
    begun, part = _processor_s(), part_of(name)
    (folder / name).mkdir(parents=True, exist_ok=True)
    row = part.judge(part.cases(asked)[case], folder / name)
    about = {"part": name, "case": case, "date": datetime.now(UTC).date().isoformat()}
    files = loaded_files(part.sources)
    return about | {"s": round(_processor_s() - begun, 2), "version": version_of(files)} | row | {"files": files}


def _processor_s() -> float:
    """Processor time of this process and of those that it waited for."""
    times = os.times()
    return times.user + times.system + times.children_user + times.children_system


def loaded_files(more: Iterable[str] = ()) -> list[str]:
    """The project's files that this process has loaded, and all below the paths `more`, relative to `ROOT`."""
    paths = {Path(file) for module in list(sys.modules.values()) if (file := getattr(module, "__file__", None))}
    own = {path for path in paths if path.is_relative_to(ROOT) and path.relative_to(ROOT).parts[0] in FOLDERS}
    for folder in {place for path in own if "src" in path.parts for place in (path.parent, path.parent / "data")}:
        own |= {path for path in folder.glob("*") if path.suffix in DATA}
    below = (path for name in more for path in (ROOT / name, *(ROOT / name).rglob("*")))
    also = {path for path in below if path.is_file() and path.suffix not in (".pyc", ".so")}
    names = {path.relative_to(ROOT).as_posix() for path in own | also}
    return sorted(name for name in names if not name.startswith(RUNNERS))


def is_older(row: Row) -> bool:
    """Whether a file has changed on which a row depends."""
    return bool(version_of(row["files"]) != row["version"])


def version_of(files: Sequence[str]) -> str:
    """Hash of the names and the content of files, words about the code apart."""
    return hashlib.sha256("".join(f"{name}\0{_content(name)}\n" for name in files).encode()).hexdigest()[:12]


@cache
def _content(name: str) -> str:
    """Hash of a file's content when it is first asked for; empty where it is gone."""
    path = ROOT / name
    if not path.is_file():
        return ""
    content = path.read_bytes()
    return hashlib.sha256(code_of(content.decode()).encode() if path.suffix == ".py" else content).hexdigest()


def code_of(text: str) -> str:
    """Python source without docstrings, comments and lines that hold nothing else."""
    lines, last, gone = text.splitlines(), tokenize.NEWLINE, set()
    tokens = list(tokenize.generate_tokens(io.StringIO(text).readline))
    for token, after in pairwise(tokens):
        (first, begin), (end, _) = token.start, token.end
        if token.type == tokenize.COMMENT:
            lines[first - 1] = lines[first - 1][:begin].rstrip()
        if token.type == tokenize.NL and not lines[first - 1].strip():
            gone.add(first)
        if token.type == tokenize.STRING and last in STATEMENT_BEGINS and after.type in STATEMENT_ENDS:
            gone |= set(range(first, end + 1))
        if token.type not in (tokenize.COMMENT, tokenize.NL):
            last = token.type
    return "\n".join(line for number, line in enumerate(lines, 1) if number not in gone)
