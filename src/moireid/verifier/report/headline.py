"""The headline of a film: the result in one line, what it means, and what to do next.

Convention: the headline names a badge's holder only if a registry vouches for the name.  It says "genuine" only if the
fringes follow the law, and failures come before what is inconclusive.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from moireid.provenance import BadgeHolder, Revocation
from moireid.verifier.explanations.table import cause_of, in_words
from moireid.verifier.explanations.words import does, how_far
from moireid.verifier.report.circumstances import Circumstances, ClaimNote, claimed_in, day
from moireid.verifier.report.finding_words import (
    GENERAL,
    Finding,
    Findings,
    first_open,
    sorted_findings,
    words_of,
)
from moireid.verifier.report.rival_table import rivals_in

#: Findings on the law itself; all others are not about the motion of the fringes.
LAW = ("gain", "parts", "residual", "window_correlation", "overlap_law", "genuine")
#: What the fringes do where no rival says so, by the finding that fails, the first that does.
BROKEN = {
    "parts": "move apart from one part of the badge to another",
    "window_correlation": "do not go with the badge's motion",
    "overlap_law": "leave the law while the badge is before the face",
}
#: What a badge is that does not count, whatever its film shows.
REVOKED = "is no longer valid"
DISTRUST = "Do not use this film as proof. If you think that it is genuine, ask for the file as the camera made it."


@dataclass(frozen=True)
class Headline:
    """The result in a line, its meaning in a sentence or two, and what to do next.

    colour: "accept", "reject" or "inconclusive"; title, text, advice: plain text, with names as they are.
    """

    colour: str
    title: str
    text: str
    advice: str

    @property
    def mark(self) -> str:
        """A sign for people who do not see the colour."""
        return {"accept": "✓", "reject": "✗"}.get(self.colour, "?")


def headline_of(document: Mapping[str, Any], known: Circumstances) -> Headline:
    """The headline of a report.

    Parameters: document: what `verify --json` or `identify --json` prints; known: with the holder of the badge read.
    """
    found = sorted_findings(document["reasons"])
    claimed = claimed_in(document)
    verdict = document.get("finding") or document["verdict"]
    if verdict in ("accept", "found"):
        return _genuine(document, claimed, known)
    if verdict == "inconclusive" and not found.fail:
        return _open(document, found)
    return _refused(document, found, claimed, known)


def _genuine(document: Mapping[str, Any], claimed: ClaimNote, known: Circumstances) -> Headline:
    law = "The fringes moved as a real badge's do"
    if document.get("finding") == "found":
        name = known.read.name if known.read else document.get("found_name") or document["found_id"]
        text = f"{law}, and this registry issued the badge to {name}."
        if known.bundle is not None:
            text += f" So says its authority, in a bundle that counts until {known.bundle}."
        return Headline("accept", f"Genuine, and {name}'s", text, _look(name))
    if document["identity"]["verdict"] == "not_claimed":
        text = f"{law}. No person was claimed, so this does not show whose badge it is."
        return Headline("accept", "Genuine; no person was claimed", text, "To learn whose badge it is, name a person.")
    if not claimed.vouched:
        text = "The film shows the badge of the file that was given. No one vouches for the name in that file."
        advice = "Ask the issuer of such badges for the registry, and check again with it."
        return Headline("accept", "Genuine, and the badge of the file", text, advice)
    text = f"{law}, and it shows the identity that was issued to {claimed.with_line}."
    if document["identity"].get("built") == "agrees":
        since = document["identity"].get("built_since")
        dated = f", on record since {day(since, known.checked_at)}" if since else ""
        text += f" The film's figures are those measured at enrolment{dated}; a copy that is built anew has others."
    if known.bundle is not None:
        text += f" So says the registry's authority, in a bundle that counts until {known.bundle}."
    return Headline("accept", f"Genuine, and {claimed.name}'s", text, _look(claimed.name))


def _look(name: str) -> str:
    return (
        f"Look at the picture: is the badge worn by {name}, in the film's own light, with no edge around it? "
        "Only the badge was checked, in the seconds that were judged."
    )


def _open(document: Mapping[str, Any], found: Findings) -> Headline:
    """The first undecided finding says why; the others are in the list of findings."""
    first = first_open(found.open)
    because, advice = GENERAL
    if first is not None:
        known = {one.name: one.parameters for one in rivals_in(document)}
        because, advice = words_of(first, (document.get("frames") or {}).get("read"), known.get(first["code"]))
    text = "This film neither proves nor disproves the badge."
    calibrated = (document.get("invariant") or {}).get("calibrated_log10")
    if calibrated:
        text += f" By itself, how its fringes moved gives {in_words(calibrated)}."
    if first is not None and first["code"] == "level":
        text = first["text"]
    return Headline("inconclusive", f"Cannot tell: {because}", text, advice)


def _refused(document: Mapping[str, Any], found: Findings, claimed: ClaimNote, known: Circumstances) -> Headline:
    failed = found.failed
    held = (document.get("invariant") or {}).get("verdict") == "accept"
    if "revoked" in failed:
        return _barred(document, failed["revoked"], claimed, known)
    broken = [code for code in LAW if code in failed]
    if broken:
        text = "So this is no film of a real badge that moved as the picture shows."
        return Headline("reject", f"The fringes do not follow the law: they {_how(document, failed)}", text, DISTRUST)
    if "cells_move" in failed:
        text = "A code that stays still was put between fringes that move."
        return Headline("reject", "The badge's code is a still picture", text, DISTRUST)
    if "name" in failed:
        text = f"The registry issued this badge to {claimed.name}. The file that was given names somebody else."
        return Headline("reject", "The name in the file is wrong", text, "Do not trust the source of that file.")
    if "enrolled" in failed:
        return _not_held(failed["enrolled"], held, known)
    if "identities" in failed:
        text = "A film that is cut together from several, or a badge that was exchanged, looks like this."
        return Headline("reject", "Several badges, one after another", text, DISTRUST)
    if "beats" in failed:
        text = "The badge's code is that of one badge, and the fringes of its rows are those of another."
        return Headline("reject", "Put together from two badges", text, DISTRUST)
    if "identity" in failed:
        return _another(held, claimed, known)
    if "built" in failed:
        text = f"The fringes move as a real badge's do, but not with the figures of the enrolment of {claimed.whose}."
        advice = f"Ask {claimed.name} whether the badge was lost, or its files were copied."
        return Headline("reject", f"A copy of {claimed.whose}", text, advice)
    first = found.fail[0]["text"] if found.fail else "What was asked for is not shown."
    return Headline("reject", "Not accepted", first, DISTRUST)


def _barred(document: Mapping[str, Any], finding: Finding, claimed: ClaimNote, known: Circumstances) -> Headline:
    """A badge that was revoked: this comes before all else."""
    rest = {
        ("accept", "match"): "Apart from that it is genuine: the fringes moved as a real badge's do.",
        ("accept", "mismatch"): "Besides, the film shows another badge.",
    }.get((document["invariant"]["verdict"], document["identity"]["verdict"]), "")
    if document["invariant"]["verdict"] == "reject":
        rest = "Besides, the fringes do not follow the law."
    whose = claimed.whose.capitalize() if not claimed.vouched else claimed.whose
    text = f"{whose} {REVOKED}. {rest}".strip()
    advice = f"Accept no film of this badge. Ask {claimed.name} for one of the badge that replaced it."
    title = f"Revoked: {finding['measured']}" if known.barred is None else _bar(known.barred, known)
    return Headline("reject", title, text, advice)


def _bar(barred: Revocation, known: Circumstances) -> str:
    """Why a badge does not count, in a line, such as: Revoked on 3 May: lost on the train."""
    return f"Revoked on {day(barred.at, known.checked_at)}: {barred.reason}"


def _another(held: bool, claimed: ClaimNote, known: Circumstances) -> Headline:
    """The film shows another badge than the claimed one, whose holder the registry may know."""
    genuine, read = ("Genuine, but " if held else "Another badge: "), known.read
    law = "The fringes move as a real badge's do" if held else "Whether the fringes follow the law is not decided"
    advice = f"Do not take this film as one of {claimed.name}. Ask who can be seen in it."
    if not claimed.vouched:
        advice = "Do not take this film as one of that badge. Ask who can be seen in it."
    if read is None:
        where = "registry" if known.bundle is None else "bundle"
        unknown = known.standing
        other = f"held by no one in this {where}, and" if unknown else "another badge,"
        text = f"{law}, but it is not {claimed.whose}."
        return Headline("reject", f"{genuine}{other} not {claimed.possessive}", text, advice)
    holder, title = read.name, f"{genuine}{read.name}'s, not {claimed.possessive}"
    if claimed.vouched and read.name == claimed.name:
        holder, title = read.with_line, f"{genuine}{_of_namesakes(read, claimed)}"
        advice = f"Do not take this film as one of {claimed.with_line}. Ask which of them can be seen in it."
    text = f"{law}, and the registry issued the badge that is shown to {holder}."
    if read.barred is not None:
        bar = _bar(read.barred, known)
        text += f" It was {bar[0].lower()}{bar[1:]}."
    return Headline("reject", title, text, advice)


def _of_namesakes(read: BadgeHolder, claimed: ClaimNote) -> str:
    """Whose badge is shown, and whose was claimed, of two people of one name: by their lines where these differ."""
    if read.line == claimed.line:
        return f"another badge of the name {read.name}, not the one that was claimed"
    other = "the one that was claimed" if claimed.line is None else f"that of {claimed.with_line}"
    return f"the badge of {read.with_line}, not {other}"


def _not_held(finding: Finding, held: bool, known: Circumstances) -> Headline:
    """No person was claimed, and no valid holder has the badge that is shown."""
    if known.read is not None and known.read.barred is not None:
        text = f"The badge was issued to {known.read.name}, and {REVOKED}."
        return Headline("reject", _bar(known.read.barred, known), text, "Accept no film of this badge.")
    where = "registry" if known.bundle is None else "bundle"
    title = f"Genuine, but held by no one in this {where}" if held else f"Held by no one in this {where}"
    return Headline("reject", title, finding["text"], "If it should be known, ask which registry issued it.")


def _how(document: Mapping[str, Any], failed: Mapping[str, Finding]) -> str:
    """What the fringes do instead of following the law."""
    cause, gain = cause_of(rivals_in(document)), failed.get("gain")
    # A gain that some build or lens has is not why parts of a badge that move apart are rejected.
    open_gain = cause is not None and cause.name == "another_gain" and not {"gain", "residual"} & failed.keys()
    if cause is not None and cause.name != "own_motion" and not open_gain and "parts" not in failed:
        return does(cause.name, cause.parameters)
    if broken := next((words for code, words in BROKEN.items() if code in failed), None):
        return broken
    if cause is None and gain is not None and isinstance(gain["measured"], float):
        return how_far(gain["measured"] / (document["invariant"].get("gain_expected") or 1.0))
    return "differ from the law" if cause is None else does(cause.name, cause.parameters)
