"""Which pictures of a film are damaged, as far as its decoder and its container show it.

Codecs predict each picture from others, so one lost packet spoils the pictures that are decoded after it, until a key
picture starts anew.  What was lost is known in two ways:

- the decoder found it: it raised an error, or flagged a picture as damaged.  Such pictures are not judged.
- only the container says so: a packet has its flag, or its clock jumps.  A forger can write that anywhere, so these
  pictures are judged.  Where a rejection rests on them alone, the film is inconclusive.

A decoder of H.264 finds what is missing within a picture by itself, so a packet's flag says nothing more there.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from moireid.verifier.limits import MAX_STRAY_SHARE
from moireid.verifier.reasons import Level, Reason

if TYPE_CHECKING:
    import av

#: Marks of a frame: only the container says that it is damaged; the decoder found it.
CLAIMED, DAMAGED = 1, 2
#: Decoders that count the blocks of each picture, and flag one that lacks some.
SELF_CHECKING = frozenset({"h264"})
#: Frames before a damaged one that may have been decoded after it: the most that H.264 and HEVC reorder.
REORDERED = 16
#: A clock that ticked so often, each time within this share, jumps where it misses half a tick or more.  Set by hand:
#: cameras and calls of changing rate are not so even.
TICKS, EVEN_SHARE, EVEN_S, JUMP_TICKS = 8, 0.1, 0.0011, 1.5


@dataclass
class DamageWatch:
    """Marks the frames of a film while it is decoded.

    marks: one for each frame in the order in which they are shown; lost: packets that gave no picture; breaks_off:
    whether the file ends before its time; interlaced: number of such pictures.
    Convention: packets are numbered in the order of decoding; a frame has the number of its packet.
    """

    codec: str = ""
    marks: bytearray = field(default_factory=bytearray)
    lost: int = 0
    breaks_off: bool = False
    interlaced: int = 0
    _found: list[int] = field(default_factory=list)
    _claimed: list[int] = field(default_factory=list)
    _last: deque[int] = field(default_factory=lambda: deque(maxlen=REORDERED))
    _ticks_s: deque[float] = field(default_factory=lambda: deque(maxlen=TICKS))
    _clock_s: float | None = None
    _lasts_s: float = 0.0

    @property
    def damaged(self) -> int:
        """Pictures that are damaged or lost, as the decoder found."""
        return self.marks.count(DAMAGED) + self.lost

    @property
    def pending(self) -> bool:
        """Whether the decoder failed, and no key picture came since."""
        return bool(self._found)

    def packet(self, number: int, packet: av.Packet) -> None:
        """Take in a packet that is about to be decoded."""
        flagged = packet.is_corrupt and self.codec not in SELF_CHECKING
        if self._jumps(packet) or flagged:
            self._claimed.append(number)

    def error(self, number: int) -> None:
        """Record that the decoder failed at a packet."""
        self.lost += 1
        self._found.append(number)

    def frame(self, number: int, picture: Any) -> None:
        """Take in a picture as it is shown, by the number of its packet."""
        if picture.is_corrupt:
            self._found.append(number)
            # Pictures that were predicted from it may be shown before it.
            for back, earlier in enumerate(reversed(self._last), 1):
                if earlier > number:
                    self.marks[-back] = DAMAGED
        elif picture.key_frame:
            self._found = [one for one in self._found if one >= number]
            self._claimed = [one for one in self._claimed if one >= number]
        found = any(one <= number for one in self._found)
        claimed = any(one <= number for one in self._claimed)
        self.marks.append(DAMAGED if found else CLAIMED if claimed else 0)
        self._last.append(number)
        self.interlaced += bool(picture.interlaced_frame)

    def _jumps(self, packet: av.Packet) -> bool:
        """Whether an even clock misses a tick before this packet, and no picture was said to last so long.

        In MP4 each picture lasts until the next one, so none is missing by its clock.
        """
        if packet.dts is None or packet.time_base is None:
            return False
        now_s, before_s, lasts_s = float(packet.dts * packet.time_base), self._clock_s, self._lasts_s
        self._clock_s, self._lasts_s = now_s, float((packet.duration or 0) * packet.time_base)
        if before_s is None:
            return False
        ticks, tick_s = self._ticks_s, now_s - before_s
        usual_s = sorted(ticks)[TICKS // 2] if len(ticks) == TICKS else 0.0
        even = usual_s > 0 and max(abs(one - usual_s) for one in ticks) <= max(EVEN_SHARE * usual_s, EVEN_S)
        if even and tick_s > JUMP_TICKS * usual_s:
            return tick_s > JUMP_TICKS * lasts_s
        ticks.append(tick_s)
        return False

    def findings(self, expected: int | None) -> tuple[Reason, ...]:
        """The finding on damage, once all was read; empty where there is none.

        Parameters: expected: pictures that the file says it has.
        """
        read = len(self.marks) + self.lost
        share = self.damaged / read if read else 0.0
        text = ""
        if self.damaged:
            text = f"{self.damaged} of {read} pictures are damaged or lost, by errors of the decoder; none is judged."
        if self.breaks_off or read < (1 - MAX_STRAY_SHARE) * (expected or 0):
            whole = f" of {expected}" if expected and expected > read else ""
            text += f"{' ' if text else ''}The file breaks off after picture {read}{whole}."
        if not text:
            return ()
        level: Level = "note" if share <= MAX_STRAY_SHARE else "undecided"
        if level == "undecided":
            text += f" At most {100 * MAX_STRAY_SHARE:.0f} % may be damaged; give the file as the camera made it."
        return (Reason("damaged", level, share, MAX_STRAY_SHARE, "share", text),)


def claimed_finding() -> Reason:
    """The finding on a rejection that rests on pictures of which the container says that they are damaged."""
    text = (
        "Where the fringes leave the law, packets of the film are missing, as its flags or its clock say, so these "
        "pictures prove nothing. Give the file as the camera made it."
    )
    return Reason("damaged", "undecided", None, None, "", text)
