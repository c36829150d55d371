"""A package that loads a module only when one of its names is used (PEP 562).

So `import moireid.simulate` is fast, and needs no optional package until a film is made.  It imports nothing itself, as
`import moireid` loads it.
"""

from __future__ import annotations

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from typing import Any


def lazy(room: str, homes: Mapping[str, str]) -> Callable[[str], Any]:
    """The `__getattr__` of a package.

    Parameters: homes: public name -> module of the package that defines it; "" for a module by that name.

    Raises: AttributeError, by the returned function, for a name that is not public.
    """

    def find(name: str) -> Any:
        import importlib

        if name not in homes:
            raise AttributeError(f"module {room!r} has no attribute {name!r}")
        home = importlib.import_module(f"{room}.{homes[name] or name}")
        return getattr(home, name) if homes[name] else home

    return find


def from_room(module: str, name: str) -> Any:
    """A name of a module that is loaded now.

    With it an object of the ground shows itself by what a room above it draws (`Badge.show`): a view for people, on
    which no work and no verdict depends.  `tests/test_imports.py` lists who may.
    """
    import importlib

    return getattr(importlib.import_module(module), name)
