"""A film or a live picture from its first frame to the verdict.

claim.py          what a film is checked against
film.py           the numbered steps: a film in, a Report out
streaming.py      frame by frame, a running verdict
badge_session.py  one badge of a film
chapters.py       a chapter judged, several joined
result.py         the Report and its JSON
cover.py          of which seconds the verdict speaks
identify.py       no claim: who is it?
capture.py        a film of a badge, for enrolment
overlap.py        the badge in front of the face
faces.py          the face, by dlib's detector
threads.py        memory that was freed, given back to the system
"""
