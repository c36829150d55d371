"""Options of one subject, gathered into one argument of the command."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import fields
from functools import wraps
from typing import Any

#: A command's function, or what makes another of it.
Command = Callable[..., Any]


def gathered(name: str, into: type, options: Sequence[Command]) -> Command:
    """Give a command these options; it takes them as the argument `name`, a dataclass with a field for each."""

    def given_to(command: Command) -> Command:
        @wraps(command)
        def taking(*args: Any, **given: Any) -> Any:
            own = into(**{field.name: given.pop(field.name) for field in fields(into)})
            return command(*args, **{name: own}, **given)

        for option in reversed(options):
            taking = option(taking)
        return taking

    return given_to
