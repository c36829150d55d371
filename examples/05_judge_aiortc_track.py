"""Judge a video track of aiortc: that of a peer, or here that of a film, which is played in time.

python 05_judge_aiortc_track.py FILM BADGE.json
"""

import asyncio
import sys
import time
from concurrent.futures import ThreadPoolExecutor

from aiortc import MediaStreamError, MediaStreamTrack
from aiortc.contrib.media import MediaPlayer

from moireid.badge import load_badge
from moireid.verifier import Claim
from moireid_studio.challenge import StreamCheck


async def judge(track: MediaStreamTrack, badge_json: str) -> str:
    """The verdict on a track, once it has ended."""
    badge = load_badge(badge_json)
    with ThreadPoolExecutor(1) as aside:  # A running verdict takes half a second, which no picture should wait for.
        # The sender says when a picture was taken.  With prompts, hold that against our own clock: live=True.
        check = StreamCheck(Claim(badge, badge.id), live=False, aside=aside)
        try:
            while True:
                frame = await track.recv()
                for event in check.push(frame.to_ndarray(format="gray"), frame.time, time.monotonic()):
                    print(f"{event['time_s']:6.1f} s  {event['verdict']}")
        except MediaStreamError:
            return str(check.finish()["verdict"])


async def main(film: str, badge_json: str) -> None:
    """Play a film into the judge."""
    print(await judge(MediaPlayer(film).video, badge_json))


if __name__ == "__main__":
    asyncio.run(main(*sys.argv[1:3]))
