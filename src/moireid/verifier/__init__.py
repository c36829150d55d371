"""Film in, verdict out.  This room never imports simulate or fabrication: a judge is not tested by its accomplice.

video.py      grey frames with their times                measure.py    two signals: measured and predicted phase
markers.py    finding the page                            invariant.py  does the phase follow the optics?
register.py   registering it to the print                 identity.py   which payload do the cells spell?
strips.py     brightness profiles of the grating          reasons.py    findings with value, limit and unit
track.py      the pass over the film                      verify.py     the numbered steps, and the Report
camera.py     poses of all frames                         identify.py   no claim: who is it?
predict.py    the phase that the optics say               report.py     the report for people: page and plots
fringe.py     frequency and phase of a strip              cells.py      phases of the cells, shapes by waveform.py
sample.py     a bounded sample of a long film             built.py      original or copy; capture.py enrols
film_wide.py  focal length, shutter, distortion.py        minimise.py   least misfit; smooth.py the course
plane_pose.py both poses of a plane, all frames at once  near_poses.py the same, near poses that are known
chapters.py   a chapter judged, several joined            segments.py   the verdict by time
figures.py    the figures of one grating                  likelihood.py how much likelier of a true badge?
within.py     do places within a strip move alike?        steady.py     a steady course asks for the focal length
template.py   the markers as a picture shows them         borders.py    the gratings' borders, where two are seen
shaken.py     frames that motion smeared                  stream.py     frame by frame, a running verdict
published.py  the published pipeline, a baseline          corners.py    corners given by hand, followed
by_corners.py a badge that lost its markers               own_page.py   ... followed by the rest of its print
page_warp.py  what corners by hand are wrong by
still.py      a photograph, or a film's first frames      chart.py      bands of a pitch test sheet; lens_fit.py fits
"""

from moireid.verifier.chapters import Claim
from moireid.verifier.stream import Running, Verifier
from moireid.verifier.verify import Report, verify
from moireid.verifier.video import Film, Frame

__all__ = ["Claim", "Film", "Frame", "Report", "Running", "Verifier", "verify"]
