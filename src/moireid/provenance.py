"""Where a claim comes from: a registry vouches for a name, a file vouches for nothing."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Source = Literal["registry", "file"]


@dataclass(frozen=True)
class Provenance:
    """Where the claimed badge and its name come from.

    source: "registry" where an authority signed them, "file" where somebody handed them over; file_name: the name in
    such a file, where the registry holds its identity under another one; alike: name and id of enrolled people whose
    names are others and look like the claimed one.
    """

    source: Source
    file_name: str | None = None
    alike: tuple[str, ...] = ()


#: What is known of a badge.json that somebody hands over.
FROM_FILE = Provenance("file")
