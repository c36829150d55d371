"""Template, badge and content → pieces with their places, page mm; and notes about content that is not shown.

Convention: a piece's rectangle is the room that it has; words are set within it when they are drawn.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from moireid.artwork.clear import BLEED_MM, LEAST_MM, areas_of, check_clear, overlap
from moireid.artwork.colours import INK, PAPER, Colour, letters_on, readable, tint
from moireid.artwork.content import Artwork, lines_of
from moireid.artwork.pictures import QUIET_MODULES, modules_of
from moireid.artwork.template import BadgeTemplate, Place, Side
from moireid.badge import Badge, CodedFrame, Rect
from moireid.errors import SpecError

if TYPE_CHECKING:
    from PIL import Image


#: Pieces that are words; the others are pictures.
WORDS = {"name", "words", "lines", "line1", "line2", "line3", "line4", "id"}
#: A picture next to words takes at most this share of the row's width; the gap between pieces is this share of the
#: row's height, within bounds.
PICTURE_SHARE, GAP_SHARE, MOST_GAP_MM, LEAST_GAP_MM = 0.4, 0.2, 5.0, 1.5
#: Pieces keep this share of their place's height to its upper and lower edge; more within a ground or between rules.
AIR_SHARE, INSET_SHARE = 0.06, 0.15
RULE_MM = 0.5
#: Lower-case letters of 7 points, 0.54 of that high, are 11.5 minutes of arc high from `READ_FROM_M`; an eye of 20/40
#: (6/12) reads letters of 10.  Source: ISO 8596: letters of 20/20 are 5 minutes of arc high.
#: A badge that is filmed from nearer is read from nearer, and its words may be smaller in proportion.
LEAST_POINTS, READ_FROM_M, NEAREST_M = 7.0, 0.4, 0.3
#: Of a room that is both head and upper, or both foot and lower, the outer one's share.
OUTER_SHARE = 0.36


@dataclass(frozen=True)
class Look:
    """How one badge looks: its template and content."""

    template: BadgeTemplate
    content: Artwork

    @property
    def accent(self) -> Colour:
        """The person's colour, or else the template's."""
        return self.content.colour or self.template.colour

    def shows(self, badge: Badge, what: str) -> bool:
        """Whether a badge has a piece; name, id and QR code are always there."""
        if what in ("logo", "portrait"):
            return getattr(self.content, what) is not None
        if what.startswith("line"):
            return len(lines_of(badge)) >= (1 if what == "lines" else int(what[4:]))
        return True


@dataclass(frozen=True)
class ArtPiece:
    """One piece on the page.

    kind: "ground" (filled), "words" (name, if any, and lines), "id", "picture" or "qr"; name: set large and bold;
    lines: below it; points: most height of the name's letters; picture: RGBA; typeface: of words;
    least_points: smaller words are refused.
    """

    kind: str
    rect_mm: Rect
    colour: Colour = INK
    name: str = ""
    lines: tuple[str, ...] = ()
    align: str = "center"
    points: float = 48.0
    picture: Image.Image | None = None
    typeface: str = "sans"
    least_points: float = LEAST_POINTS


def least_points(badge: Badge) -> float:
    """The least size of words that are read from as near as the badge is filmed."""
    near_m = badge.range_m[0] if badge.range_m else READ_FROM_M
    return LEAST_POINTS * min(max(near_m, NEAREST_M), READ_FROM_M) / READ_FROM_M


def pieces_of(badge: Badge, look: Look) -> list[ArtPiece]:
    """All pieces of a badge, those at the back first.

    Raises: SpecError where a piece would cover what is read, or has no room.
    """
    side = _side(badge, look)
    places = [(number, place) for number, place in enumerate(side.places, start=1) if _worn(badge, look, place)]
    areas = _shared_out(areas_of(badge), {place.area for _, place in places})
    pieces: list[ArtPiece] = []
    for number, place in places:
        for piece in _placed(badge, look, place, areas, f"place {number} of template {look.template.name}"):
            pieces += _on_white(badge, piece, pieces) if piece.kind == "qr" else [piece]
    return pieces


def worn_places(badge: Badge, look: Look) -> tuple[Place, ...]:
    """The places of the template that this badge fills."""
    return tuple(place for place in _side(badge, look).places if _worn(badge, look, place))


def _side(badge: Badge, look: Look) -> Side:
    x0, y0, x1, y1 = badge.outline_mm
    return look.template.side(x1 - x0, y1 - y0)


def _on_white(badge: Badge, code: ArtPiece, behind: list[ArtPiece]) -> list[ArtPiece]:
    """A QR code; where a ground or rule lies in its quiet zone, on white of its size, and smaller within."""
    modules = len(modules_of(badge.id or "none"))
    x0, y0, x1, y1 = code.rect_mm
    quiet = QUIET_MODULES * (x1 - x0) / modules
    zone = (x0 - quiet, y0 - quiet, x1 + quiet, y1 + quiet)
    if not any(piece.kind == "ground" and overlap(zone, piece.rect_mm) for piece in behind):
        return [code]
    quiet = QUIET_MODULES * (x1 - x0) / (modules + 2 * QUIET_MODULES)
    within = (x0 + quiet, y0 + quiet, x1 - quiet, y1 - quiet)
    return [ArtPiece("ground", code.rect_mm, PAPER), ArtPiece("qr", within)]


def _worn(badge: Badge, look: Look, place: Place) -> bool:
    """Whether there is something to show in a place: a piece that the person has, or a ground alone."""
    here = not place.what or any(look.shows(badge, what) for what in place.what)
    wanted = all(look.shows(badge, what) for what in place.needs)
    return here and wanted and not any(look.shows(badge, what) for what in place.lacks)


def _shared_out(areas: dict[str, Rect], used: set[str]) -> dict[str, Rect]:
    """The areas; where two that both hold something are one room, the outer one takes `OUTER_SHARE` of it."""
    for outer, inner, share in (("head", "upper", OUTER_SHARE), ("foot", "lower", 1 - OUTER_SHARE)):
        if {outer, inner} <= used and areas.get(outer) == areas.get(inner) and outer in areas:
            x0, y0, x1, y1 = areas[outer]
            cut = y0 + share * (y1 - y0)
            above, below = (x0, y0, x1, cut - LEAST_GAP_MM / 2), (x0, cut + LEAST_GAP_MM / 2, x1, y1)
            areas |= {outer: above, inner: below} if outer == "head" else {inner: above, outer: below}
    return areas


def _placed(badge: Badge, look: Look, place: Place, areas: dict[str, Rect], where: str) -> list[ArtPiece]:
    """The ground, rules and pieces of one place."""
    shown = tuple(what for what in place.what if look.shows(badge, what))
    rect = _rect_of(badge, place, areas, where)
    board = badge.outline_mm
    check_clear(badge, (board[0], rect[1], board[2], rect[3]) if place.bleed else rect, where)
    if rect[3] - rect[1] < LEAST_MM or rect[2] - rect[0] < LEAST_MM:
        raise SpecError(
            f"{where} has only {rect[2] - rect[0]:.1f} x {rect[3] - rect[1]:.1f} mm on this board; give the template "
            "more head or foot, or take a larger format"
        )
    back = _ground(badge, place, rect, look.accent)
    ground = {"accent": look.accent, "tint": tint(look.accent)}.get(place.ground, PAPER)
    framed = place.ground != "none" or place.rule != "none"
    inset = INSET_SHARE if framed else 0.0
    if not framed and set(shown) & {"name", "words"}:
        inset = AIR_SHARE
    inset *= rect[3] - rect[1]
    across = inset if place.ground != "none" and not place.bleed else 0.0
    room = (rect[0] + across, rect[1] + inset, rect[2] - across, rect[3] - inset)
    row = _row(badge, look, place, shown, room, ground) if shown else []
    for piece in row:
        wide = piece.rect_mm[2] - piece.rect_mm[0]
        if wide <= 0 or piece.rect_mm[0] < room[0] - 1e-6 or piece.rect_mm[2] > room[2] + 1e-6:
            raise SpecError(
                f"{where} has no room for {len(shown)} pieces side by side ({', '.join(shown)[:60]}); list fewer, or "
                "spread them over more places"
            )
    return [*back, *row]


def _rect_of(badge: Badge, place: Place, areas: dict[str, Rect], where: str) -> Rect:
    if place.area not in areas:
        ways = ["give a template of your own more head or foot"]
        ways += ["take markers=squares, which leave room next to them"] * isinstance(badge.markers, CodedFrame)
        ways += [f"name another area ({', '.join(areas)})"] if areas else []
        raise SpecError(f"{where}: this board has no area {place.area}; {', or '.join(ways)}")
    return areas[place.area]


def _ground(badge: Badge, place: Place, rect: Rect, accent: Colour) -> list[ArtPiece]:
    x0, y0, x1, y1 = rect
    if place.bleed:
        board = badge.outline_mm
        x0, x1 = board[0] - BLEED_MM, board[2] + BLEED_MM
    back = []
    if place.ground != "none":
        colour = {"accent": accent, "paper": PAPER}.get(place.ground, tint(accent))
        back.append(ArtPiece("ground", (x0, y0, x1, y1), colour))
    if place.rule in ("above", "both"):
        back.append(ArtPiece("ground", (x0, y0, x1, y0 + RULE_MM), accent))
    if place.rule in ("below", "both"):
        back.append(ArtPiece("ground", (x0, y1 - RULE_MM, x1, y1), accent))
    return back


def _row(badge: Badge, look: Look, place: Place, shown: tuple[str, ...], room: Rect, ground: Colour) -> list[ArtPiece]:
    """Pieces side by side: pictures as high as the row, words in what is left."""
    x0, y0, x1, y1 = room
    height, width = y1 - y0, x1 - x0
    words = [what for what in shown if what in WORDS]
    gap = min(max(GAP_SHARE * height, LEAST_GAP_MM), MOST_GAP_MM)
    most = width * (PICTURE_SHARE if words else 1.0)
    sizes = {what: _fitted(_shape(look, what), most, height) for what in shown if what not in WORDS}
    if not words:
        # Pictures alone share the width.
        wide = sum(size[0] for size in sizes.values())
        less = min(1.0, (width - gap * (len(shown) - 1)) / wide)
        sizes = {what: (less * size[0], less * size[1]) for what, size in sizes.items()}
    used = sum(size[0] for size in sizes.values()) + gap * (len(shown) - 1)
    each = (width - used) / len(words) if words else 0.0
    spare = 0.0 if words else width - used
    x = x0 + {"left": 0.0, "center": spare / 2, "right": spare}[place.align]
    pieces = []
    for what in shown:
        wide, high = sizes.get(what, (each, height))
        rect: Rect = (x, (y0 + y1 - high) / 2, x + wide, (y0 + y1 + high) / 2)
        pieces.append(_piece(badge, look, place, what, rect, ground))
        x += wide + gap
    return pieces


def _piece(badge: Badge, look: Look, place: Place, what: str, rect: Rect, ground: Colour) -> ArtPiece:
    lines = lines_of(badge)
    if what == "qr":
        return ArtPiece("qr", rect)
    if what in ("logo", "portrait"):
        return ArtPiece("picture", rect, picture=look.content.picture(what))
    style: dict[str, Any] = {"align": place.align, "points": place.points, "colour": letters_on(ground)}
    style |= {"typeface": look.template.typeface, "least_points": least_points(badge)}
    if what == "id":
        return ArtPiece("id", rect, **style)
    if what == "name":
        return ArtPiece("words", rect, name=badge.name, **style)
    if what == "words":
        return ArtPiece("words", rect, name=badge.name, lines=lines, **style)
    if what == "lines":
        return ArtPiece("words", rect, lines=lines, **style)
    style["colour"] = readable(look.accent, ground)
    return ArtPiece("words", rect, lines=(lines[int(what[4:]) - 1],), **style)


def _shape(look: Look, what: str) -> float:
    """Width over height of a picture."""
    if what == "qr":
        return 1.0
    picture = look.content.picture(what)
    assert picture is not None
    return float(picture.width / picture.height)


def _fitted(shape: float, most_width: float, most_height: float) -> tuple[float, float]:
    width = min(most_width, shape * most_height)
    return width, width / shape


_PICTURES = ("logo", "portrait")


def unworn(badge: Badge, look: Look) -> list[str]:
    """A sentence for each picture, line or colour that was given and is not shown, and for a missing name or id."""
    shown, template = shown_pieces(badge, look), f"the template {look.template.name}"
    notes = [
        f"{template} shows no {what}, so it is left out"
        for what in _PICTURES
        if look.shows(badge, what) and what not in shown
    ]
    lines = lines_of(badge)
    if lines and not shown & {"lines", "words"}:
        missing = [line for number, line in enumerate(lines, start=1) if f"line{number}" not in shown]
        notes += [f"{template} does not show the line {line[:60]!r}" for line in missing]
    if look.content.colour is not None and "colour" not in shown:
        notes.append(f"{template} has nothing in colour, so the colour is not used")
    if not shown & {"name", "words"}:
        notes.append(f"{template} does not show the name")
    if not shown & {"id", "qr"}:
        notes.append(f"{template} does not show the identity, so only badge.json states which badge this is")
    return notes


def shown_pieces(badge: Badge, look: Look) -> set[str]:
    """The pieces that the badge shows, and "colour" where one of its places has an accent."""
    places = worn_places(badge, look)
    shown = {what for place in places for what in place.what if look.shows(badge, what)}
    # A line with a place of its own is printed in the accent colour.
    accent = bool(shown & {"line1", "line2", "line3", "line4"})
    accent = accent or any(place.ground in ("accent", "tint") or place.rule != "none" for place in places)
    return shown | ({"colour"} if accent else set())
