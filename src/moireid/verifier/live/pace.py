"""How fast a challenge goes: before this device's own camera, or in a call, where each answer comes later.

In a call somebody reads each prompt aloud, the words take their way, the person reacts, and the picture takes its way
back.  How long that takes differs from call to call, so the clock waits for it: the next prompt comes only after the
last one was followed.  Whoever plays an older film can then pause it until the words come.  So no answer's time counts
for anything there, and more moves must do what times do elsewhere (`chance.py`).
"""

from __future__ import annotations

from dataclasses import dataclass

#: A move begins at earliest and at latest this long after its prompt, and ends within `DONE_S`.  People need 0.2 s to
#: react to what they see and half a second to read a word; the rest is for the delay of the picture.
SOONEST_S, LATEST_S, DONE_S = 0.15, 2.0, 3.0
#: Time between two prompts, drawn at random between these: the least is enough to finish and rest.
LEAST_GAP_S, MOST_GAP_S = 3.6, 6.4
#: Moves of a challenge, one of them across the face, and the least number that go sideways: without these, the fringes
#: of most badges hardly move and cannot be judged.
MOVES, SIDEWAYS = 6, 2

#: In a call: time for the one who asks to read a prompt aloud, and the most delay of the call, there and back.
READ_S, DELAY_S = 2.0, 2.0
CALL_LATEST_S, CALL_DONE_S = LATEST_S + READ_S + DELAY_S, DONE_S + READ_S + DELAY_S
#: In a call: the time from a followed prompt to the next.  The least is enough to come to rest.
LEAST_CALL_GAP_S, MOST_CALL_GAP_S = 1.6, 3.2
#: In a call: more moves, as times count for nothing; and more of them sideways, as the badge rests for longer between.
CALL_MOVES, CALL_SIDEWAYS = 9, 4
#: In a call the latest answer may come later than the soonest by this time: reading aloud differs by 1 s, reactions by
#: 1.5 s, and the call's delay may jump by half a second.
SPREAD_S = 3.0
#: A step's speed is measured over at least the time of a camera's frame; in a call over that of three, as two of them
#: may be lost.
FRAME_S, CALL_FRAME_S = 1 / 24, 3 / 24
#: In a call pictures may come this much later than their times say: who asks sends them, and gains nothing by a lie.
CALL_SLACK_S = 2.0
#: In a call a prompt waits for so long until the badge rests.
REST_WAIT_S = 30.0


@dataclass(frozen=True)
class Pace:
    """How many moves, and how many sideways at least; by when an answer begins and is done (s after its prompt); and
    what comes between two prompts.  frame_s: least time over which a step's speed is measured.

    in_call: the next prompt waits for the answer to the last one, and until the badge rests; gaps count from then.
    """

    moves: int
    sideways: int
    latest_s: float
    done_s: float
    gap_s: tuple[float, float]
    frame_s: float = FRAME_S
    in_call: bool = False


HERE = Pace(MOVES, SIDEWAYS, LATEST_S, DONE_S, (LEAST_GAP_S, MOST_GAP_S))
CALL = Pace(
    CALL_MOVES,
    CALL_SIDEWAYS,
    CALL_LATEST_S,
    CALL_DONE_S,
    (LEAST_CALL_GAP_S, MOST_CALL_GAP_S),
    CALL_FRAME_S,
    in_call=True,
)
