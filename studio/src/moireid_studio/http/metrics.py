"""Figures for Prometheus: requests, uploads, jobs.  No label ever holds a name, an id or a token."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable

from prometheus_client import CollectorRegistry, Counter, Histogram
from prometheus_client.core import GaugeMetricFamily
from prometheus_client.exposition import generate_latest
from prometheus_client.registry import Collector
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from moireid.errors import RegistryError

#: A gauge that is asked for when it is read: name, meaning, label or "", and values by label.
Gauge = tuple[str, str, str, Callable[[], dict[str, float]]]
#: From pages to long films, s.
BUCKETS = (0.01, 0.05, 0.1, 0.5, 1, 2, 5, 10, 30, 60, 300, 600)
#: What did not reach a route.
NO_ROUTE = "none"


class Metrics:
    """The figures of one studio."""

    def __init__(self) -> None:
        own = self._registry = CollectorRegistry()
        self.requests = Counter("moireid_requests", "Answers given.", ["method", "route", "status"], registry=own)
        self.seconds = Histogram(
            "moireid_request_seconds", "Time to an answer.", ["route"], buckets=BUCKETS, registry=own
        )
        self.uploaded = Counter("moireid_uploaded_bytes", "Bytes of requests that were received.", registry=own)
        self.ended = Counter(
            "moireid_jobs_ended", "Jobs that this process has ended.", ["kind", "outcome"], registry=own
        )
        self.working = Histogram(
            "moireid_job_seconds", "Time at work on a job.", ["kind"], buckets=BUCKETS, registry=own
        )

    def watch(self, gauges: Iterable[Gauge]) -> None:
        """Ask for these gauges whenever the figures are read."""
        self._registry.register(_RequestNotes(list(gauges)))

    def text(self) -> bytes:
        """All figures in Prometheus' text format."""
        return generate_latest(self._registry)


class _RequestNotes(Collector):
    def __init__(self, gauges: list[Gauge]) -> None:
        self._gauges = gauges

    def describe(self) -> Iterable[GaugeMetricFamily]:
        # Nothing is asked for when they are registered.
        return []

    def collect(self) -> Iterable[GaugeMetricFamily]:
        for name, meaning, label, values in self._gauges:
            family = GaugeMetricFamily(name, meaning, labels=[label] if label else [])
            try:
                for key, value in values().items():
                    family.add_metric([key] if label else [], value)
            except RegistryError:
                # A database that is away takes no other figure along.
                continue
            yield family


class RequestMetrics:
    """ASGI middleware that counts answers by the route's own pattern, and notes each in the log."""

    def __init__(self, app: ASGIApp, *, metrics: Metrics, note: Callable[[str, str, int, float], None]) -> None:
        self.app, self.metrics, self._note = app, metrics, note

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        begun, status = time.monotonic(), 500

        async def counted_receive() -> Message:
            message = await receive()
            self.metrics.uploaded.inc(len(message.get("body", b"")))
            return message

        async def noted_send(message: Message) -> None:
            nonlocal status
            if message["type"] == "http.response.start":
                status = message["status"]
            await send(message)

        try:
            await self.app(scope, counted_receive, noted_send)
        finally:
            # The pattern, such as /verify/{job_id}: an address may hold a person's name.
            seconds, route = time.monotonic() - begun, getattr(scope.get("route"), "path", NO_ROUTE)
            method = scope["method"] if scope["method"] in METHODS else "other"
            self.metrics.requests.labels(method, route, str(status)).inc()
            self.metrics.seconds.labels(route).observe(seconds)
            self._note(method, route, status, seconds)


#: Methods with a label of their own: a client may send any word there, and each label would be kept for good.
METHODS = frozenset({"GET", "HEAD", "POST", "PUT", "DELETE", "OPTIONS", "PATCH"})
