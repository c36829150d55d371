"""The headline of a live check: the result in one line, what it means, and what to do next.

The person is in front of the camera, so the advice is to begin again.

Convention: as `moireid.verifier.report.headline`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, replace
from typing import Any

from moireid.verifier.report.circumstances import Circumstances
from moireid.verifier.report.finding_words import RIVALS, SHOW, Findings, sorted_findings
from moireid.verifier.report.headline import Headline, headline_of

AGAIN = "Begin again, with the badge and the face in good light. If the result is the same, do not take it for live."
MOVE = "Begin again, and move the badge sideways by 20 cm or more, several times."
SLOWLY = "Begin again, and move the badge slowly."
PROMPTS = "Begin again, and start the challenge: who follows its prompts shows more than a film."
CHANGE = "Begin again, and move the badge to and fro at changing speed, and turn it as well."
#: Advice by the code that makes a check inconclusive.
ADVICE = {"motion": MOVE, "motion_gaps": SLOWLY, "level": PROMPTS} | dict.fromkeys(RIVALS, CHANGE) | {"still": MOVE}
LIVE_DISTRUST = (
    "Do not take this for the badge. If you think that it is, begin again in better light, with another camera."
)
PIN = "Pin the person in the call's program, so that their tile is large and stays where it is, and begin again."
RECOGNISE = "Only the badge was checked: is the face {name}'s, and does it pass behind the badge as a face does?"
#: Why a call's picture is inconclusive, for the title.
TILE = {
    "tile": "the tile is too small",
    "tile_moved": "the tile did not stay where it was",
    "faces": "several people are in the tile",
}
#: Failures of the challenge alone, the most important first: the title, and what it means.
LIVE = {
    "prompt": (
        "The prompts were not followed",
        "A film that was made earlier cannot follow prompts that are drawn now.",
    ),
    "unbroken": (
        "The badge was away between the moves",
        "It may have been exchanged for another while it was not seen.",
    ),
    "clock": (
        "The pictures came too late",
        "Pictures that come late can be made, or chosen, after the prompt is known.",
    ),
}


def live_headline_of(event: Mapping[str, Any], name: str, known: Circumstances) -> Headline:
    """The headline of a live verdict.

    Parameters: event: the event of the verdict of a live check; name: of the claimed person; known: with the holder of
    the badge that was read.
    """
    found, document = sorted_findings(event["reasons"]), dict(event) | {"badge": {"name": name}}
    film = headline_of(document, known)
    if film.colour == "accept":
        return _accepted(film, name, challenged=bool(event.get("challenged")), in_call=bool(event.get("in_call")))
    if film.colour == "inconclusive":
        poor = next((one for one in found.open if one["code"] in TILE), None)
        if poor is not None:
            return replace(film, title=f"Cannot tell: {TILE[poor['code']]}", text=poor["text"], advice=PIN)
        advice = ADVICE.get(found.open[0]["code"] if found.open else "", SHOW)
        return replace(film, text="This check neither proves nor disproves the badge.", advice=advice)
    return _refused_prompt(film, found)


def shown(headline: Headline) -> dict[str, str]:
    """A headline as the page of the live check reads it."""
    return asdict(headline) | {"mark": headline.mark}


def _accepted(film: Headline, name: str, *, challenged: bool, in_call: bool) -> Headline:
    if challenged and in_call:
        text = f"{film.text} It was moved in this call now, as you asked: the prompts were drawn at random."
        return replace(film, title=f"Genuine, live, and {name}'s", text=text, advice=RECOGNISE.format(name=name))
    if challenged:
        text = f"{film.text} It was held before this camera now: the prompts were drawn at random, and followed."
        return replace(
            film, title=f"Genuine, live, and {name}'s", text=text, advice=f"See for yourself that it is {name}."
        )
    text = f"{film.text} No challenge was made, so this may be an old film."
    return replace(film, title=f"{film.title}, but perhaps not live", text=text, advice="Start the challenge.")


def _refused_prompt(film: Headline, found: Findings) -> Headline:
    failed = found.failed
    of_challenge = next((code for code in LIVE if code in failed), None)
    if of_challenge is None or set(failed) - set(LIVE):
        return replace(film, advice=LIVE_DISTRUST)
    title, means = LIVE[of_challenge]
    return Headline("reject", title, f"{failed[of_challenge]['text']} {means}", AGAIN)
