"""A package that loads a module only when one of its names is used (PEP 562).

So `import moireid.simulate` is fast, and needs no optional package until a film is made.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping
from typing import Any


def lazy(room: str, homes: Mapping[str, str]) -> Callable[[str], Any]:
    """The `__getattr__` of a package; `homes`: public name -> module of the package that defines it.

    Raises: AttributeError, by the returned function, for a name that is not public.
    """

    def find(name: str) -> Any:
        if name not in homes:
            raise AttributeError(f"module {room!r} has no attribute {name!r}")
        return getattr(importlib.import_module(f"{room}.{homes[name]}"), name)

    return find
