"""The text of a STEP assembly as the CAD kernel writes it, made the same for the same badge, and with names of places.

The kernel numbers the places of an assembly through all files of a process, gives them names such as "=>[0:1:1:2]", and
writes colours last, in the order of addresses in memory; those that are equal share lines.  Here places are numbered
from 1 and named as their parts, and each body has colour lines of its own, in the order of the bodies.

Source: ISO 10303-21 (STEP's text form), ISO 10303-44 (next_assembly_usage_occurrence).
"""

from __future__ import annotations

import re
from collections.abc import Sequence

_PLACE = re.compile(r"NEXT_ASSEMBLY_USAGE_OCCURRENCE\('[^']*','[^']*'([^;]*);")
#: The line that begins a body's colour.
_COLOURED = "MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION"
_REFERENCE = re.compile(r"#(\d+)")


def ordered_step(step: str, names: Sequence[str]) -> str:
    """The text with numbered and named places and ordered colours.

    Parameters
    ----------
    step : str
        A file of one assembly, whose places are in the order of the names, its colours last.
    names : sequence of str
        Of the parts, without quotes.

    Returns
    -------
    str
        The text, which means the same.
    """
    numbered = iter(enumerate(names, start=1))

    def place(match: re.Match[str]) -> str:
        number, name = next(numbered, (0, ""))
        # Where the kernel breaks the line depends on the length of its own number and name.
        rest = re.sub(r"\n *", "", match[1])
        return f"NEXT_ASSEMBLY_USAGE_OCCURRENCE('{number}','{name}'{rest};" if number else match[0]

    step = _PLACE.sub(place, step)
    begin = re.search(rf"(?m)^#\d+ = {_COLOURED}", step)
    if begin is None:
        return step
    head, (tail, end) = step[: begin.start()], step[begin.start() :].split("ENDSEC;", maxsplit=1)
    lines = dict(re.findall(r"(?ms)^#(\d+) = (.*?;)$", re.sub(r"\n +", "", tail)))
    first = min(int(number) for number in lines)
    roots = [number for number, text in lines.items() if text.startswith(_COLOURED)]
    written: list[str] = []

    def write(number: str) -> int:
        """Write a line and all that it refers to below the bodies; its new number."""
        own = first + len(written)
        written.append("")
        written[own - first] = f"#{own} = " + _REFERENCE.sub(
            lambda m: f"#{write(m[1]) if m[1] in lines else m[1]}", lines[number]
        )
        return own

    def body(number: str) -> int:
        """The body that a line's colour is given to: the last line before the colours that is referred to."""
        styled = next(m for m in _REFERENCE.findall(lines[number]) if m in lines)
        return max(int(m) for m in _REFERENCE.findall(lines[styled]) if m not in lines)

    for root in sorted(roots, key=body):
        write(root)
    return head + "\n".join(written) + "\nENDSEC;" + end
