"""The guides as a reader follows them: a page's blocks, in order, in one shell and one Python for each page.

In a `console` block a line that begins with `$ ` is typed, with the lines by which it goes on (after a backslash, or up
to the END of `<< END`); the lines below must come out, whole and in that order, with anything between them; `…` is
for any letters.  What `ls` shows is all that there is, in any columns.  What is typed ends with exit code 0, or says
another: `# exit code 3`.  A server runs until the page ends.  What a `python` block prints is
in a `text` block after it.  A block that is not run has `<!-- not run: reason -->` above it.
"""

from __future__ import annotations

import os
import re
import signal
import socket
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType

#: The port that pages write; each session has a free one in its place.
PORT = "8000"
SERVER = re.compile(r"moireid serve\b")
FENCE = re.compile(
    r"(?:^<!-- not run: (?P<why>.+?) -->\n)?^```(?P<kind>\w+)\n(?P<body>.*?)^```$", re.MULTILINE | re.DOTALL
)
STATED = re.compile(r"\s+# exit code (\d+)$")
#: What is typed goes on to the line of that word.
HERE = re.compile(r"<< (\w+)$")
MARK = "\x1e"
#: A Python that takes a block as its length and its text, runs it among the names of those before, and reports its end.
PYTHON = f"""
import sys, traceback
names = {{"__name__": "__main__"}}
while line := sys.stdin.readline():
    block = sys.stdin.read(int(line))
    code = 0
    try:
        exec(compile(block, "the page's block", "exec"), names)
    except BaseException:
        traceback.print_exc(file=sys.stdout)
        code = 1
    print("\\n{MARK}%d" % code, flush=True)
"""


@dataclass(frozen=True)
class Block:
    """A fenced block of a page; why: the reason for which it is not run."""

    kind: str
    body: str
    line: int
    why: str | None


def blocks_of(page: Path) -> list[Block]:
    """All fenced blocks of a page, in order."""
    text = page.read_text(encoding="utf-8")
    found = []
    for match in FENCE.finditer(text):
        line = text.count("\n", 0, match.start("kind")) + 1
        found.append(Block(match["kind"], match["body"], line, match["why"]))
    return found


def commands_of(block: Block) -> list[tuple[str, list[str]]]:
    """What is typed in a console block, and the lines shown below it."""
    found: list[tuple[str, list[str]]] = []
    until = ""
    for line in block.body.splitlines():
        typed = found[-1][0] if found else ""
        if until or typed.endswith("\\"):
            found[-1] = (f"{typed}\n{line}", [])
            until = "" if line == until else until
        elif line.startswith("$ "):
            found.append((line[2:], []))
        elif found:
            found[-1][1].append(line)
        else:
            raise AssertionError(f"line {block.line}: a console block begins with a line that is typed, `$ …`")
        if begun := HERE.search(line) if line.startswith("$ ") else None:
            until = begun[1]
    return found


def unseen(shown: list[str], said: str) -> str | None:
    """The first of the lines shown that does not come in what was said, after those before it."""
    said_lines = iter(line.strip() for line in said.splitlines())
    for line in shown:
        pattern = ".*".join(re.escape(part) for part in line.strip().split("…"))
        if not any(re.fullmatch(pattern, each) for each in said_lines):
            return line
    return None


class Session:
    """A reader at work in a folder."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        with socket.socket() as asked:
            asked.bind(("127.0.0.1", 0))
            self._port = str(asked.getsockname()[1])
        path = f"{Path(sys.executable).parent}:{os.environ['PATH']}"
        apart = {"XDG_DATA_HOME": str(folder / ".data"), "MOIREID_KEYS": str(folder / ".keys"), "PATH": path}
        # Each page goes on alone with a copy of one registry, which those who saw another page's would call a fork.
        apart |= {"MOIREID_SEEN": str(folder / ".seen.sqlite3")}
        self._environ = os.environ | apart | {"NUMBA_NUM_THREADS": "1", "LC_ALL": "C.UTF-8", "COLUMNS": "120"}
        self._bash, self._python = self._start("bash", "--norc"), self._start(sys.executable, "-c", PYTHON)

    def __enter__(self) -> Session:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        for process in (self._bash, self._python):
            # With all that it has started.
            os.killpg(process.pid, signal.SIGTERM)
            process.wait(20)
            for stream in (process.stdin, process.stdout):
                if stream is not None:
                    stream.close()

    def follow(self, page: Path) -> None:
        """Do all that a page says.  Raises: AssertionError that shows the place."""
        before: str | None = None
        for block in blocks_of(page):
            where = f"{page.name}, line {block.line}"
            if block.why is not None:
                continue
            if block.kind == "console":
                for typed, shown in commands_of(block):
                    self._type(typed, [line.replace(PORT, self._port) for line in shown], where)
            elif block.kind == "python":
                code = block.body.replace(PORT, self._port)
                ended, before = self._ask(self._python, f"{len(code)}\n{code}")
                assert ended == 0, f"{where}: the block fails\n{before}"
            elif block.kind == "text" and before is not None:
                line = unseen(block.body.splitlines(), before)
                assert line is None, f"{where}: {line!r} is shown, but what comes is\n{before}"
            if block.kind != "python":
                before = None

    def _type(self, typed: str, shown: list[str], where: str) -> None:
        stated = STATED.search(typed)
        wanted = int(stated[1]) if stated else 0
        command = STATED.sub("", typed).replace(PORT, self._port)
        if SERVER.match(command):
            ended, said = self._serve(command)
        else:
            ended, said = self._ask(self._bash, f"{{ {command}\n}} < /dev/null; printf '\\n{MARK}%d\\n' $?\n")
        assert ended == wanted, f"{where}: $ {typed}\nends with exit code {ended}, not {wanted}\n{said}"
        if command.startswith("ls "):
            assert " ".join(shown).split() == said.split(), f"{where}: $ {typed}\nshows\n{said}"
            return
        line = unseen(shown, said)
        assert line is None, f"{where}: $ {typed}\n{line!r} is shown, but what comes is\n{said}"

    def _serve(self, command: str) -> tuple[int, str]:
        """A server in the background, once it says where it is."""
        log = self.folder / ".served.txt"
        self._ask(self._bash, f"{command} > {log.name} 2>&1 < /dev/null & printf '\\n{MARK}0\\n'\n")
        begun = time.monotonic()
        while "http://" not in (said := log.read_text() if log.exists() else ""):
            if time.monotonic() - begun > 60:
                return 1, said
            time.sleep(0.05)
        return 0, said

    def _ask(self, process: subprocess.Popen[str], text: str) -> tuple[int, str]:
        assert process.stdin is not None and process.stdout is not None
        process.stdin.write(text)
        process.stdin.flush()
        said = []
        for line in process.stdout:
            if line.startswith(MARK):
                return int(line[1:]), "".join(said)
            said.append(line)
        raise AssertionError(f"the session broke off at\n{text}\n{''.join(said)}")

    def _start(self, *command: str) -> subprocess.Popen[str]:
        return subprocess.Popen(
            command,
            cwd=self.folder,
            env=self._environ,
            text=True,
            encoding="utf-8",
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
