"""The QR code of an identity.

It says `moireid:` and the id, which stands on the badge in letters too, so it tells no secret and proves nothing: who
scans it knows what to look up.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

#: White around the code, in modules (ISO/IEC 18004 asks for four).
QUIET_MODULES = 4


def words_of(badge_id: str) -> str:
    """What the code says."""
    return f"moireid:{badge_id}"


@lru_cache(maxsize=256)
def modules_of(badge_id: str) -> Sequence[Sequence[bool]]:
    """The modules of the code without its white border, True where dark; square, row by row from the top.

    Source: ISO/IEC 18004 by segno, at level M, which mends 15 %.
    """
    import segno

    code = segno.make_qr(words_of(badge_id), error="m", boost_error=False)
    return tuple(tuple(bool(module) for module in row) for row in code.matrix)
