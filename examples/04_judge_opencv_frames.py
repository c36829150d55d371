"""Judge what OpenCV reads: a film, or a camera by its number.

python 04_judge_opencv_frames.py FILM|NUMBER BADGE.json
"""

import sys
import time

import cv2

from moireid.badge import load_badge
from moireid.verifier import Question
from moireid_studio.challenge import StreamCheck


def main(source: str, badge_json: str, seconds: float = 30.0) -> str:
    """The verdict on a film, or on some seconds of a camera."""
    badge, live = load_badge(badge_json), source.isdigit()
    check, camera = StreamCheck(Question(badge, badge.id), live=live), cv2.VideoCapture(int(source) if live else source)
    begun = time.monotonic()
    while (now := time.monotonic()) - begun < seconds and (picture := camera.read()[1]) is not None:
        stated_s = camera.get(cv2.CAP_PROP_POS_MSEC) / 1000
        # When it was taken, by the film or by the camera's driver; if that gives no time, when it came.
        taken_s = stated_s if stated_s > 0 or not live else now
        for event in check.push(cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY), taken_s, now):
            print(f"{event['time_s']:6.1f} s  {event['verdict']}")
    return str(check.finish()["verdict"])


if __name__ == "__main__":
    print(main(*sys.argv[1:3]))
