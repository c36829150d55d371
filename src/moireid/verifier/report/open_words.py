"""Why a film can be left open, in a few words, and what to do next; by the code of the finding."""

from __future__ import annotations

from dataclasses import dataclass

NEARER = "Ask for another film: the whole badge from nearer, in even light, moved sideways several times."
ORIGINAL = "Ask for the file as the camera made it, or for another film with such functions switched off."
MOVE = "Ask for another film in which badge or camera moves sideways by 20 cm or more, several times."
SHOW = (
    "Begin again: hold the badge with its four corner markers, or its frame, in the picture, near the face, in good "
    "light."
)


@dataclass(frozen=True)
class Words:
    """The end of "Cannot tell: …", and a sentence on what to do."""

    because: str
    advice: str


GENERAL = Words("the film shows too little", NEARER)
OPEN = {
    "badge_absent": Words("the badge is hardly to be seen", NEARER),
    "fringes": Words("no fringes could be read", NEARER),
    "motion": Words("the badge hardly moved", MOVE),
    "leaps": Words(
        "the badge moved only where pictures are missing",
        "Ask for another film in one piece; in a call, for a faster connection.",
    ),
    "views": Words(
        "the film shows few views of the badge, as a few photographs would",
        "Ask for another film with more and slower moves, or with more frames a second.",
    ),
    "correlation": Words("the fringes are not clear enough", NEARER),
    "gain": Words(
        "how far the fringes move does not settle it",
        "Whoever issued the badge can enroll it with a film of it; then its own measure is known.",
    ),
    "residual": Words("the fringes stray, perhaps by the film's own faults", NEARER),
    "agreement": Words("parts of the badge do not quite agree", NEARER),
    "likelihood": Words("the film is not clear enough", NEARER),
    "steady": Words("the motion was too even", "Ask for another film: moved to and fro at changing speed, and turned."),
    "spacing": Words("the fringes do not follow the distance, as after a zoom", ORIGINAL),
    "waveform": Words("the fringes look uneven, as from cross-faded pictures", NEARER),
    "edges": Words(
        "the fringes look soft, as in a blurred or mixed picture",
        "Ask for another film from nearer and in focus. A sheet that does not lie flat makes soft fringes too.",
    ),
    "cross_fade": Words(
        "the fringes change as those of a few photographs do",
        "Ask for another film in even light, with the badge moved on and on.",
    ),
    "photographs": Words(
        "a few photographs of the badge could make this film",
        "Ask for a longer film, moved sideways and also to and from the camera.",
    ),
    "focal": Words("the picture looks stretched or cut out", ORIGINAL),
    "camera": Words("the picture may have been zoomed, reframed or stabilised", ORIGINAL),
    "mixed_frames": Words("frames are mixed with their neighbours", ORIGINAL),
    "small": Words("the badge is too small in the picture", NEARER),
    "covered": Words(
        "something covers the badge", "Ask for another film in which no hand, caption or glare covers it."
    ),
    "strays": Words("the badge does not lie flat in too many frames", NEARER),
    "unsearched": Words(
        "the badge may have been in view where nobody looked",
        "Ask for another film, before a plainer background, that shows the badge throughout.",
    ),
    "cover": Words(
        "the badge is judged in too few of the film's seconds",
        "Look at the bar of seconds: judge only those, or ask for a film that shows the badge throughout.",
    ),
    "corners": Words("the badge's markers are hidden", NEARER),
    "piece": Words(
        "the film is in pieces that are too short", "Check the pieces one by one, or ask for a longer film."
    ),
    "identity": Words("whose badge it is cannot be read", NEARER),
    "beats": Words("the badge's code could not be confirmed", NEARER),
    "cells_move": Words("the badge's code does not quite move with its rows", NEARER),
    "built": Words(
        "it may be a copy", "Ask for another film, from nearer and with more motion; or let copies pass knowingly."
    ),
    "others_break": Words(
        "another badge in the film breaks the law", "Watch the seconds that the finding names, and judge them apart."
    ),
    "layout": Words("one kind of badge in the registry cannot be checked", "Tell whoever keeps the registry."),
    "face": Words("no face was found", "Ask for another film with the face from the front, well lit."),
    "overlap": Words("the badge is not before the face long enough", "Ask that it be held across the face for 2 s."),
    "overlap_law": Words("the badge before the face cannot be read", NEARER),
    "challenge": Words("the challenge was not finished", SHOW),
    "prompt": Words("a prompt could not be judged", SHOW),
    "unbroken": Words("the badge, or the picture, was lost during the moves", SHOW),
    "window_correlation": Words("nothing moved", MOVE),
}
