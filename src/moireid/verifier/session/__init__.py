"""A film or a live picture from its first frame to the verdict.

streaming.py      frame by frame, a running verdict    badge_session.py  one badge of a film
chapters.py       a chapter judged, several joined     film.py           the numbered steps, and the Report
identify.py       no claim: who is it?                 capture.py        a film of a badge, for enrolment
overlap.py        the badge before the face            faces.py          the face, by dlib's detector
"""
