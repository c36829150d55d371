"""Errors that people and programs get: a code and one sentence."""

from __future__ import annotations

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
