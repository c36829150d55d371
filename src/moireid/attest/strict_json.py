"""JSON from strangers, read strictly: one meaning for every reader, and no way to exhaust this one."""

from __future__ import annotations

import base64
import binascii
import json
import math
from typing import Any

#: A report nests six deep, and its numbers have at most six digits and an exponent, or are counts.
MOST_DEPTH, MOST_DIGITS = 32, 40


def strict_object(content: bytes) -> dict[str, Any]:
    """The JSON object that `content` holds.

    Raises: ValueError, with a few words for people, where it is no JSON, names a key twice, holds a number that JSON
        has not, nests too deeply, or is no object.
    """
    try:
        document = json.loads(
            content.decode("utf-8"),
            object_pairs_hook=_once,
            parse_constant=_number,
            parse_float=_number,
            parse_int=_integer,
        )
    except UnicodeDecodeError as error:
        raise ValueError("it is no UTF-8 text") from error
    except json.JSONDecodeError as error:
        raise ValueError(f"it is no JSON: {error.msg} at letter {error.pos}") from error
    except RecursionError as error:
        raise ValueError("its JSON nests too deeply") from error
    if not isinstance(document, dict):
        raise ValueError("it is JSON, but no object")
    if _deeper_than(document, MOST_DEPTH):
        raise ValueError("its JSON nests too deeply")
    return document


def strict_base64(text: object) -> bytes:
    """The bytes of a base64 text, which must be spelled as encoders spell it.  Raises: ValueError."""
    if not isinstance(text, str):
        raise ValueError("it is no base64 text")
    try:
        content = base64.b64decode(text.encode("ascii"), validate=True)
    except (UnicodeEncodeError, binascii.Error) as error:
        raise ValueError("it is no base64 text") from error
    # Spare bits at the end would let two texts mean the same bytes.
    if base64.b64encode(content).decode() != text:
        raise ValueError("its base64 text is not spelled as encoders spell it")
    return content


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) < len(pairs):
        # Readers differ in which of the two they take, so two people would read two reports.
        raise ValueError("it names a key twice")
    return found


def _number(word: str) -> float:
    if len(word) > MOST_DIGITS or not math.isfinite(number := float(word)):
        raise ValueError(f"it holds {word[:20]}, which is no number of JSON that everybody reads alike")
    return number


def _integer(word: str) -> int:
    if len(word) > MOST_DIGITS:
        raise ValueError(f"it holds a number of {len(word)} digits")
    return int(word)


def _deeper_than(document: Any, depth: int) -> bool:
    """Whether lists and objects nest deeper; level by level, so that no depth exhausts the stack."""
    level = [document]
    for _ in range(depth):
        level = [
            inner
            for one in level
            if isinstance(one, (dict, list))
            for inner in (one.values() if isinstance(one, dict) else one)
        ]
    return bool(level)
