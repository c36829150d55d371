"""From a name, a lens, a printer and a viewing range to a Badge that can work there.

request.py   what a person asks for
payload.py   the payload of a name, or the one given
layout.py    where markers, grating and bands lie on the page
design.py    the choice of beat frequencies, and the Badge
"""

from moireid.designer.design import design_badge, explain
from moireid.designer.payload import payload_for_name, payload_from_hex
from moireid.designer.request import Request

__all__ = ["Request", "design_badge", "explain", "payload_for_name", "payload_from_hex"]
