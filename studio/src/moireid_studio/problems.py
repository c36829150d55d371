"""Errors that people and programs get: a code and one sentence."""

from __future__ import annotations

import re
from typing import Any

from pydantic import BaseModel


class Problem(BaseModel):
    """The content of an error's answer: `code` for programs, `text` for people."""

    code: str
    text: str


class Refusal(Exception):
    """A request that is refused: HTTP status, code and sentence; raise it from any route."""

    def __init__(self, status: int, code: str, text: str, *, headers: dict[str, str] | None = None) -> None:
        super().__init__(text)
        self.status, self.code, self.text, self.headers = status, code, text, headers


def problem_responses(*statuses: int) -> dict[int | str, dict[str, Any]]:
    """The `responses` of a route that may answer with these problems, for /openapi.json."""
    return {status: {"model": Problem} for status in statuses}


#: What the library says for programs, as the fields of the pages say it; the first that fits counts.
PLAIN = (
    (r" \((lens|lens_thickness_mm|mount|mount_mm|registry|size_mm)\)| \(orientation=[a-z]+\)", ""),
    (r"markers=squares", "squares as markers"),
    (r"axes=x or xy", "fringes that sense motion sideways, or sideways and up and down"),
    (r"axes=xy", "fringes that sense motion sideways and up and down"),
    (r"run the command again", "issue the badges again"),
    (
        r"\b(axes|colour|format|front|lens|lines|logo|markers|mount|orientation|paper|portrait|size|template)(?:_mm)?=",
        r"\1 ",
    ),
)


def plain(sentence: str) -> str:
    """A sentence of the library without the words of programs."""
    for pattern, words in PLAIN:
        sentence = re.sub(pattern, words, sentence)
    return sentence
