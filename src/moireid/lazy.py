"""A room's face that loads a module only when one of its names is asked for (PEP 562).

So `import moireid.simulate` costs nothing until a film is made, and needs no package of an extra.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping
from typing import Any


def lazy(room: str, homes: Mapping[str, str]) -> Callable[[str], Any]:
    """The `__getattr__` of a room: `homes` says for each public name in which of the room's modules it is at home.

    Raises: AttributeError, by the function returned, for a name that the room does not offer.
    """

    def find(name: str) -> Any:
        if name not in homes:
            raise AttributeError(f"module {room!r} has no attribute {name!r}")
        return getattr(importlib.import_module(f"{room}.{homes[name]}"), name)

    return find
