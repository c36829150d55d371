"""A live check: random prompts that the person must follow.

challenge.py      random prompts are drawn, and checked: were they followed?
chance.py         the chance that an older film follows; the tile of a call
clock.py          when a live frame was taken, and how fast a challenge goes
session.py        a live session, of frames and events
stream.py         a live check of any stream, with a film's report
witnessed.py      figures of a badge that followed prompts, to enroll it by
live_headline.py  its result in one line, and what to do next
"""

from typing import TYPE_CHECKING

from moireid.lazy import lazy

if TYPE_CHECKING:
    from moireid_studio.challenge.stream import StreamCheck

__all__ = ["StreamCheck"]
__getattr__ = lazy(__name__, {"StreamCheck": "stream"})
