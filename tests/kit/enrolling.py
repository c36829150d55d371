"""What the registry's tests have other processes do; they import this module by its name, and nothing heavy with it."""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Iterable
from dataclasses import replace
from multiprocessing.context import ForkServerContext
from typing import Any

from moireid.badge import Badge, badge_from_json
from moireid.errors import RegistryError
from moireid.registry import open_registry


def prepared() -> ForkServerContext:
    """Processes forked from one that has loaded the registry, which takes longer than most of what they do.

    They have the environment of that one's start, so they are given the place of this test's keys.
    """
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["moireid.registry.store"])
    return context


def renamed(badge: Badge, name: str, number: int) -> str:
    """The JSON of `badge` with another name and id: the registry reads no code, and designing takes longer."""
    return replace(badge, name=name, id=number.to_bytes(3, "big").hex()).to_json()


def enroll_many(url: str, keys: str, badges: Iterable[str], ready: Any, results: Any) -> None:
    """Open, and enroll all, telling how each went."""
    os.environ["MOIREID_KEYS"] = keys
    ready.wait()
    outcomes = []
    with open_registry(url, create=True) as registry:
        for text in badges:
            try:
                outcomes.append(registry.enroll(badge_from_json(text)).name)
            except RegistryError as error:
                outcomes.append(f"RegistryError: {error}")
    results.put(outcomes)
