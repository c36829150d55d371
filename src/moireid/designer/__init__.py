"""From a name, a lens, a printer and a viewing range to a Badge that works there.

order.py    the order for a badge, checked; its payload, given or drawn at random
layout.py   the places of markers, or of the coded frame, and of gratings on the page
grid.py     how a grating is cut into rows and cells
reach.py    the distances at which a board can be read, and a film judged; the link budget of each receiver
design.py   the choice of beat frequencies, and the Badge
formats.py  sizes that holders are made for, each with its sheet and range
explain.py  a designed badge in figures
list_table.py  a list as spreadsheets save it: encoding, separator, rows
chart.py    the pitch test sheet
"""

from typing import TYPE_CHECKING

from moireid.designer.design import design_badge
from moireid.designer.explain import explain
from moireid.designer.order import Order, payload_from_hex, random_payload
from moireid.lazy import lazy

if TYPE_CHECKING:
    from moireid.designer.chart import design_chart

__all__ = [
    "Order",
    "design_badge",
    "design_chart",
    "explain",
    "payload_from_hex",
    "random_payload",
]

__getattr__ = lazy(__name__, {"design_chart": "chart"})
