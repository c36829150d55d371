"""From a name, a lens, a printer and a viewing range to a Badge that works there.

request.py        the request for a badge, checked
payload.py        the payload: given, or drawn at random
formats.py        sizes that holders are made for, each with its sheet and range
layout.py         the places of markers and gratings on the page
turned_fields.py  three fields that sense 0, 60 and 120 degrees
fiducial.py       the coded frame, and how far a fiducial is followed
grid.py           how a grating is cut into rows and cells, also under a lens array
link.py           the link budget: the share of films in which the whole payload is read, for each receiver
reach.py          the distances at which a board can be read, and a film judged
design.py         the choice of beat frequencies, and the Badge
people.py         a list of people (CSV), and the badge of each
drawn.py          the badge with a given identity, or with a random one that no one else has
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
