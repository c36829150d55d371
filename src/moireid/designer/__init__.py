"""From a name, a lens, a printer and a viewing range to a Badge that can work there.

request.py        what a person asks for
payload.py        the payload: given, or drawn by chance
formats.py        sizes that holders are made for, each with its sheet and range
layout.py         where markers and gratings lie on the page
turned_fields.py  three fields that sense 0, 60 and 120 degrees
fiducial.py       the coded frame, and how far a fiducial is followed
grid.py           how a grating is cut into rows and cells
link.py           the link budget: in how many films, by whom, is the whole payload read?
reach.py          from where to where a board is read, and judged
design.py         the choice of beat frequencies, and the Badge
people.py         a list of people, and the badge of each
drawn.py          the badge with a given identity, or with a drawn one that nobody else has
chart.py          the pitch test sheet
"""

from moireid.designer.chart import ChartRequest, design_chart
from moireid.designer.design import design_badge, explain
from moireid.designer.payload import payload_from_hex, payload_from_key, random_payload
from moireid.designer.request import Request

__all__ = [
    "ChartRequest",
    "Request",
    "design_badge",
    "design_chart",
    "explain",
    "payload_from_hex",
    "payload_from_key",
    "random_payload",
]
