"""Error against run time of the identity stage: clips read as if they had ended earlier, by both decoders."""

from __future__ import annotations

from typing import Any

import numpy as np


def shorter_figures(groups: dict[str, list[dict[str, Any]]]) -> list[dict[str, Any]]:
    """One row for each condition and number of frames: cells wrong, payloads read and wrong, milliseconds.

    Convention: milliseconds are medians; `measure` is camera and fringes, `identity` the decoding.
    """
    found = []
    for name, rows in groups.items():
        by_length: dict[int, list[dict[str, Any]]] = {}
        for row in rows:
            for shorter in row["shorter"]:
                by_length.setdefault(shorter["frames"], []).append(shorter)
        # Few films lose frames; lengths that hardly any clip has are left out.
        for frames, some in sorted(by_length.items()):
            if len(some) * 2 < len([row for row in rows if row["shorter"]]):
                continue
            found.append(
                {
                    "name": name,
                    "frames": frames,
                    "clips": len(some),
                    "cells_wrong": float(np.mean([one["cells_wrong"] for one in some])),
                    "soft_read": float(np.mean([one["soft"] is True for one in some])),
                    "hard_read": float(np.mean([one["hard"] is True for one in some])),
                    "wrong_payloads": sum(one["soft"] is False or one["hard"] is False for one in some),
                    "measure_ms": 1e3 * float(np.median([one["measure_s"] for one in some])),
                    "identity_ms": 1e3 * float(np.median([one["identity_s"] for one in some])),
                }
            )
    return found
