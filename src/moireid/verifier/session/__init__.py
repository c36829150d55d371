"""A film or a live picture from its first frame to the verdict.

claim.py          what a film is checked against
film.py           the numbered steps: a film in, a Report out
streaming.py      frame by frame, a running verdict
badge_session.py  one badge of a film
chapters.py       a chapter judged, several joined
check_level.py    what level of proof is asked for, and reached
result.py         the Report and its JSON
cover.py          which seconds of the film were judged
identify.py       without a claim: whose badge is it?
capture.py        a film of a badge, for enrolment
known_figures.py  what it shows, next to the figures that are known
refusal.py        why a badge as built may not have been accepted
overlap.py        the badge in front of the face
faces.py          the face, by dlib's detector
threads.py        judging in the background, and freed memory returned to the system
"""
