"""What the tests share: one seeded generator, a badge, and the films made outside the project."""

from __future__ import annotations

import os
import signal
from collections.abc import Generator
from pathlib import Path

import numpy as np
import pytest

from kit.payloads import payload_for_name
from kit.places import FILMS
from moireid.badge import Badge, load_badge
from moireid.designer import Order, design_badge

# Started in the background of a shell, a program is deaf to interrupts, and so is all that it starts; tests send some.
signal.signal(signal.SIGINT, signal.default_int_handler)
#: The developer's own options do not count.
for name in ("REGISTRY", "LENS", "PAPER", "ACTOR", "PUBLIC_URL"):
    os.environ.pop(f"MOIREID_{name}", None)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport() -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Where CI is set, a test that is skipped has failed: all that it needs is installed there."""
    report = yield
    return failed_in_ci(report) if "CI" in os.environ else report


def failed_in_ci(report: pytest.TestReport) -> pytest.TestReport:
    """The report, as a failure where the test was skipped; one that is expected to fail is none of those."""
    if report.skipped and not hasattr(report, "wasxfail"):
        report.outcome, report.longrepr = "failed", f"skipped, which CI does not allow: {report.longrepr}"
    return report


@pytest.fixture(scope="session", autouse=True)
def seen_registries(tmp_path_factory: pytest.TempPathFactory) -> None:
    """What tests see of registries is not remembered in the developer's home; programs that they start inherit it."""
    os.environ["MOIREID_SEEN"] = str(tmp_path_factory.mktemp("seen") / "seen.sqlite3")


@pytest.fixture
def rng() -> np.random.Generator:
    """The one source of chance in tests; its seed is fixed."""
    return np.random.default_rng(20260)


@pytest.fixture(scope="session")
def ada() -> Badge:
    """A badge of the default design."""
    return design_badge(Order("Ada Lovelace", lens="50lpi"), payload_for_name("Ada Lovelace"))


@pytest.fixture(scope="session")
def films() -> Path:
    """Films made outside the project: an independent tracer, with true poses (data/films/README.md)."""
    return FILMS


@pytest.fixture(scope="session")
def prototype(films: Path) -> Badge:
    """The published prototype board, described by hand."""
    return load_badge(films / "badge.json")
