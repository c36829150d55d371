"""What somebody gave for a badge, and the template does not show."""

from __future__ import annotations

from moireid.artwork.content import lines_of
from moireid.artwork.placing import Look, worn_places
from moireid.artwork.template import TEMPLATES, template_named
from moireid.badge import Badge

_PICTURES = ("logo", "portrait")


def unworn(badge: Badge, look: Look) -> list[str]:
    """A sentence for each picture, line or colour that was given and is not shown; and where no name or id is."""
    shown, template = shown_pieces(badge, look), f"the template {look.template.name}"
    told = [
        f"{template} shows no {what}, so it is left out{_instead(badge, look, what)}"
        for what in _PICTURES
        if look.shows(badge, what) and what not in shown
    ]
    lines = lines_of(badge)
    if lines and not shown & {"lines", "words"}:
        missing = [line for number, line in enumerate(lines, start=1) if f"line{number}" not in shown]
        told += [f"{template} does not show the line {line[:60]!r}" for line in missing]
    if look.content.colour is not None and "colour" not in shown:
        told.append(f"{template} has nothing in colour, so the colour is not used")
    if not shown & {"name", "words"}:
        told.append(f"{template} does not show the name")
    if not shown & {"id", "qr"}:
        told.append(f"{template} does not show the identity, so only badge.json tells which badge this is")
    return told


def shown_pieces(badge: Badge, look: Look) -> set[str]:
    """The pieces that the badge shows, and "colour" where one of its places has an accent."""
    places = worn_places(badge, look)
    shown = {what for place in places for what in place.what if look.shows(badge, what)}
    # A line that stands alone is lettered in the accent.
    accent = bool(shown & {"line1", "line2", "line3", "line4"})
    accent = accent or any(place.ground != "none" or place.rule != "none" for place in places)
    return shown | ({"colour"} if accent else set())


def _instead(badge: Badge, look: Look, what: str) -> str:
    """Which templates that come with the program would show it on this board."""
    able = [
        name
        for name in TEMPLATES
        if name != look.template.name
        and what in shown_pieces(badge, Look(template_named(name), look.content, look.corner_mm))
    ]
    return f"; {' and '.join(able)} {'show' if len(able) > 1 else 'shows'} one" if able else ""
