"""Days that people give with a badge: until when it counts, and since when it is compromised.

Convention: ISO 8601, such as 2027-05-03, in UTC.
"""

from __future__ import annotations

import re
from datetime import date

from moireid.errors import SpecError
from moireid.registry.canonical import utc_now

_DAY = re.compile(r"\d{4}-\d{2}-\d{2}")


def expiry_day(text: str) -> str:
    """The last day on which a badge counts.  Raises: SpecError where it is no day, or in the past."""
    day, today = _day(text, "expiry"), utc_now()[:10]
    if day < today:
        raise SpecError(f"the day of expiry {day} is over (today is {today}); give one to come")
    return day


def compromise_day(text: str) -> str:
    """The day from which on a badge's films count for nothing.  Raises: SpecError where it is no day, or to come."""
    day, today = _day(text, "compromise"), utc_now()[:10]
    if day > today:
        raise SpecError(f"the day of compromise {day} is to come (today is {today}); give the first day of doubt")
    return day


def _day(text: str, what: str) -> str:
    try:
        # `fromisoformat` also reads 20270503 and 2027-W18-1, which do not compare as text.
        if not _DAY.fullmatch(text):
            raise ValueError
        return date.fromisoformat(text).isoformat()
    except ValueError as error:
        raise SpecError(f"the day of {what} {text[:40]!r} is none; give one such as 2027-05-03") from error
