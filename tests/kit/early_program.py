"""A program that starts as `moireid verify` does, and whose film takes over the process that reads it.

It prints how often a secret is in the memory of that process: `python -m kit.early_program SECRET`.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

from moireid.sandbox.early_copy import EarlyCopy, restart, resume


def main() -> None:
    """Have the memory searched, and print what was found there, and what this program itself has."""
    from kit.film_taken_over import HostileOrder
    from moireid.reading.film_reader import film_reader

    with film_reader([Path("none.mp4")]) as reader:
        found = reader.read(HostileOrder("search"), lambda done, of: None)["result"]["got"]
    sys.stdout.write(" ".join([found, sys.argv[1], os.environ["PGPASSWORD"], *reader.sealed]))


if __name__ == "__main__":
    if not sys.argv[1].isdecimal():
        restart("kit.early_program")
    from kit.film_taken_over import HostileOrder as _  # noqa: F401
    from moireid.reading.film_work import read

    EarlyCopy.waiting = EarlyCopy(read)
    resume(int(sys.argv[1]))
    main()
