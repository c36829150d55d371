"""The ledger of claims: what the documents promise, with the one test that holds each.

A test is marked with `@pytest.mark.claim("…")`, and `make claims` writes tests/claims.md from the marks.
"""

from __future__ import annotations

import ast
from pathlib import Path

from kit.places import ROOT, TESTS

LEDGER = TESTS / "claims.md"
HEAD = """# Claims

What the documents promise, and the test that holds it. `make claims` writes this page from the tests' marks.
`make test ARGS="-m claim"` runs these tests alone.
"""


def claims() -> list[tuple[str, str, str]]:
    """Each claim with its test's file, from the project's root, and the test's name, in the order of the files."""
    files = sorted(
        path for folder in ("tests", "studio/tests", "lab/tests") for path in (ROOT / folder).rglob("test_*.py")
    )
    return [claim for path in files for claim in _claims_of(path)]


def ledger() -> str:
    """The text of tests/claims.md."""
    return "\n".join([HEAD, *(f"- {text}: `{file}::{test}`" for text, file, test in claims()), ""])


def _claims_of(path: Path) -> list[tuple[str, str, str]]:
    tests = [node for node in ast.parse(path.read_bytes()).body if isinstance(node, ast.FunctionDef)]
    return [
        (mark.args[0].value, path.relative_to(ROOT).as_posix(), test.name)
        for test in tests
        for mark in test.decorator_list
        if isinstance(mark, ast.Call) and ast.unparse(mark.func) == "pytest.mark.claim"
        if isinstance(mark.args[0], ast.Constant)
    ]


if __name__ == "__main__":
    LEDGER.write_text(ledger(), encoding="utf-8")
