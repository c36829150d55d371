"""How often a token may ask, by its role.  The counts are those of this process; each studio has its own."""

from __future__ import annotations

import math
import time

from limits import RateLimitItemPerMinute
from limits.storage import MemoryStorage
from limits.strategies import MovingWindowRateLimiter

from moireid_studio.auth.tokens import Role
from moireid_studio.problems import Refusal
from moireid_studio.settings import Limits


class Rates:
    """Counts of requests and uploads by token, within a minute that ends now."""

    def __init__(self, limits: Limits) -> None:
        self._limits = limits
        self._window = MovingWindowRateLimiter(MemoryStorage())

    def request(self, owner: str) -> None:
        """Count a request.  Raises: Refusal 429 where the token has sent too many."""
        self._count("requests", owner, self._limits.requests_a_minute)

    def upload(self, owner: str, role: Role) -> None:
        """Count an upload, or an order.  Raises: Refusal 429 where the token has sent too many."""
        most = self._limits.uploads_a_minute
        self._count("uploads", owner, most if role == "verifier" else 2 * most)

    def _count(self, what: str, owner: str, most: int) -> None:
        item = RateLimitItemPerMinute(most)
        if self._window.hit(item, what, owner):
            return
        wait_s = max(math.ceil(self._window.get_window_stats(item, what, owner).reset_time - time.time()), 1)
        raise Refusal(
            429,
            "rate",
            f"This token has sent {most} {what} within a minute, which is as many as it may; go on in {wait_s} s.",
            headers={"Retry-After": str(wait_s)},
        )
