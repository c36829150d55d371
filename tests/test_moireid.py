"""`import moireid as mo`: what it loads and offers."""

from __future__ import annotations

import inspect
import subprocess
import sys
from pathlib import Path

import pytest

import moireid as mo
from kit.places import ROOT
from moireid.cli.simulate_cmd import simulate_command

NAMES = (
    "AsBuilt Badge CodeError DesignError FabricationError FilmCheck MediaError MissingExtraError MoireIdError Order "
    "Registry RegistryError SpecError __version__ design identify load_badge mount_solids print_badge simulate verify"
)


def run(code: str) -> list[str]:
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()


def test_the_names_are_pinned_and_exist() -> None:
    """Catches: a renamed, lost or unintended name; one that is listed and cannot be loaded."""
    assert mo.__all__ == dir(mo) == NAMES.split()
    assert [name for name in mo.__all__ if not hasattr(mo, name)] == []
    with pytest.raises(AttributeError, match="module 'moireid' has no attribute 'verfy'"):
        _ = mo.verfy  # type: ignore[attr-defined]


def test_importing_moireid_loads_nothing_else() -> None:
    """Catches: a name that is loaded before it is used; the parts that a prompt would wait for."""
    before = "import sys; before = set(sys.modules); import moireid; "
    loaded = run(before + "print(*sorted(sys.modules.keys() - before))")
    assert set(loaded) <= {"__future__", "moireid", "moireid.lazy", "moireid.version"}


def test_simulate_has_the_parameters_and_defaults_of_the_command() -> None:
    """Catches: a default that is another than that of `moireid simulate`; an option that is forgotten unnoticed."""
    parameters = dict(inspect.signature(mo.simulate).parameters)
    assert all(f"\n{name} : " in str(inspect.getdoc(mo.simulate)) for name in parameters)
    options = simulate_command.make_context("simulate", ["badge.json", "--out", "film.mp4"]).params
    for name in ("badge", "video", "progress"):
        del parameters[name]
    assert set(options) - set(parameters) == {"badge_json", "video", "as_json", "explain"}
    for name, parameter in parameters.items():
        assert options[name] == parameter.default, name


@pytest.mark.slow
def test_a_type_checker_knows_the_names(tmp_path: Path) -> None:
    """Catches: lazy names that are `Any` to a type checker, so that a wrong argument passes."""
    lines = ("import moireid as mo", "", "mo.verify('x.mp4', clam='Ada')", "mo.simulate(3, 'x.mp4')")
    (tmp_path / "asked.py").write_text("\n".join((*lines, "reveal_type(mo.design)")))
    command = [sys.executable, "-m", "mypy", "--follow-imports=silent", "--cache-dir", str(tmp_path / "cache")]
    done = subprocess.run([*command, tmp_path / "asked.py"], cwd=ROOT, capture_output=True, text=True, check=False)
    assert 'asked.py:3: error: Unexpected keyword argument "clam"' in done.stdout
    assert 'asked.py:4: error: Argument 1 to "simulate" has incompatible type "int"' in done.stdout
    assert "def (name: " in done.stdout and done.stdout.count("error:") == 2
