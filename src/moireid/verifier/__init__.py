"""Film in, verdict out.  This package never imports simulate or fabrication: it must not share their mistakes.

The folders in the order in which the data flows; a folder never imports one that is listed below it:

kernel/        what each frame needs, in C
tracking/      where the page is in each frame, and the brightness along its rows
camera/        where the camera was, from the page's corners alone
fringes/       the phase of the fringes, measured and predicted
explanations/  the law of optics and its rivals, each a small model of the same fringes
identity/      whose badge is it, do its code's rows move along, and is it the one that was enrolled?
decision/      which explanation holds: the motion invariant
session/       a film or a live picture from its first frame to the verdict
report/        the report for people

opened_file.py  an open file that several readers share
video.py      a film's grey frames with their times
tracks.py     the video tracks of a file, and what players may show instead
damage.py     which frames are damaged
picture.py    one frame, turned into counts where it is read
limits.py     constants of the motion test, with their sources
measuring.py  constants of measuring, identity and enrolment, with their sources
reasons.py    findings with value, limit and unit
timeline.py   rising frame times, and time intervals
signal_table.py  the signals of a film as named columns
series.py     medians, means, greatest values and splines over frames
"""

from moireid.lazy import lazy
from moireid.question import KnownCamera, Question

TYPE_CHECKING = False
if TYPE_CHECKING:
    from moireid.verifier.picture import Frame
    from moireid.verifier.report.circumstances import Circumstances
    from moireid.verifier.report.report_page import write_report
    from moireid.verifier.session.film import verify
    from moireid.verifier.session.identify import Identification, identify
    from moireid.verifier.session.result import Report
    from moireid.verifier.session.streaming import Running, Verifier
    from moireid.verifier.video import Film

__all__ = [
    "Circumstances",
    "Film",
    "Frame",
    "Identification",
    "KnownCamera",
    "Question",
    "Report",
    "Running",
    "Verifier",
    "identify",
    "verify",
    "write_report",
]

__getattr__ = lazy(
    __name__,
    {
        "Circumstances": "report.circumstances",
        "Film": "video",
        "Frame": "picture",
        "Identification": "session.identify",
        "Report": "session.result",
        "Running": "session.streaming",
        "Verifier": "session.streaming",
        "identify": "session.identify",
        "verify": "session.film",
        "write_report": "report.report_page",
    },
)
