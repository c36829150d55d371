"""The work of the process that reads films: one order.  What reading needs is loaded with this file."""

from __future__ import annotations

from typing import TYPE_CHECKING

import moireid.verifier.session.film  # noqa: F401

if TYPE_CHECKING:
    from moireid.reading.film_orders import Order
    from moireid.sandbox.child import Talk


def read(talk: Talk) -> None:
    """Read what the order asks for."""
    order: Order | None = talk.next()
    if order is not None:
        for part in order(talk.progress):
            talk.send(part)
