"""What is given to a public function, compared with its annotations and with what its arguments may be.

Python compares neither; without it, what is wrong is said deep inside, in words of the inside.
"""

from __future__ import annotations

import collections.abc
import math
import types
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cache, wraps
from inspect import signature
from numbers import Integral, Real
from os import PathLike
from typing import Any, Literal, ParamSpec, TypeVar, Union, get_args, get_origin, get_type_hints

from moireid.errors import SpecError

Given = ParamSpec("Given")
Answer = TypeVar("Answer")
#: The least and the most of a number, or the words that a text may be.
Bounds = tuple[float, float] | tuple[str, ...]
_WORDS: dict[Any, str] = {
    str: "text",
    bytes: "bytes",
    int: "a whole number",
    float: "a number",
    bool: "True or False",
    PathLike: "a pathlib.Path",
    collections.abc.Callable: "a function",
    collections.abc.Mapping: "a dict",
}
_hints = cache(get_type_hints)


def checked(**bounds: Bounds) -> Callable[[Callable[Given, Answer]], Callable[Given, Answer]]:
    """A function whose arguments are compared with its annotations, and with bounds by their names, when it is called.

    Raises: SpecError, by the function, with the argument that does not fit, and what would.
    """

    def decorate(function: Callable[Given, Answer]) -> Callable[Given, Answer]:
        @wraps(function)
        def call(*given: Given.args, **named: Given.kwargs) -> Answer:
            bound = signature(function).bind(*given, **named)
            check_values(function, bound.arguments, bounds)
            return function(*given, **named)

        return call

    return decorate


def check_values(annotated: Any, values: Mapping[str, Any], bounds: Mapping[str, Bounds]) -> None:
    """Raise SpecError where a value does not fit its annotation or its bounds; annotated: a function or a class."""
    for name, value in values.items():
        hint = _hints(annotated).get(name, Any)
        if not _fits(value, hint):
            raise SpecError(f"{name}={value!r:.60} is not possible; give {_words(hint)}")
        allowed = bounds.get(name, ())
        if value is None or not allowed:
            continue
        each = value if isinstance(value, list | tuple) else (value,)
        if isinstance(allowed[0], str):
            fits, words = (one in allowed for one in each), listed(map(str, allowed))
        else:
            fits, words = (allowed[0] <= one <= allowed[-1] for one in each), f"{allowed[0]:.10g} to {allowed[-1]:.10g}"
        if not all(fits):
            raise SpecError(f"{name}={value!r:.60} is not possible; give {words}")


def listed(words: Iterable[str]) -> str:
    """Such as "a, b or c"."""
    *rest, last = words
    return f"{', '.join(rest)} or {last}" if rest else last


def _fits(value: Any, hint: Any) -> bool:
    """Whether a value is what an annotation says; a number is finite, and a list may stand for a tuple."""
    origin, parts = get_origin(hint), get_args(hint)
    if hint is Any or isinstance(hint, TypeVar):
        return True
    if origin in (Union, types.UnionType):
        return any(_fits(value, part) for part in parts)
    if origin is Literal:
        return value in parts
    if origin is tuple and Ellipsis not in parts:
        whole = isinstance(value, tuple | list) and len(value) == len(parts)
        return whole and all(map(_fits, value, parts))
    if origin is not None and issubclass(origin, Mapping):
        return isinstance(value, Mapping) and all(isinstance(key, parts[0]) for key in value)
    if origin is not None and issubclass(origin, Sequence):
        return isinstance(value, Sequence) and not isinstance(value, str) and all(_fits(one, parts[0]) for one in value)
    if hint in (int, float):
        number = isinstance(value, Integral if hint is int else Real) and not isinstance(value, bool)
        return number and math.isfinite(value)
    return isinstance(value, origin or hint)


def _words(hint: Any) -> str:
    """An annotation in words."""
    origin, parts = get_origin(hint), get_args(hint)
    if origin in (Union, types.UnionType):
        return listed(dict.fromkeys(_words(part) for part in parts if part is not type(None)))
    if origin is Literal:
        return listed(map(str, parts))
    if origin is tuple:
        return f"({', '.join(map(_words, parts))})"
    if origin is not None and issubclass(origin, Sequence):
        return f"a list, each entry {_words(parts[0])}"
    kind: Any = origin or hint
    return _WORDS.get(kind, f"a {kind.__name__}")
