"""The rooms of the house and who may enter which, held by a walk through the syntax tree.

`verifier` never imports `simulate` or `fabrication`: a judge is not tested by its own accomplice.  The rules are those
of the project's design; each entry of `MAY_IMPORT` is one row of its table of rooms.
"""

from __future__ import annotations

import ast
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import moireid
from moireid.cli.simulate_cmd import FORGERIES
from moireid.simulate.forgeries.courses import KINDS

ROOT = Path(moireid.__file__).parent
#: What any room may import: the frozen data, the optics, the errors, and writing files.
GROUND = {"asbuilt", "badge", "dots", "errors", "extras", "fiducials", "files", "kept"}
GROUND |= {"lazy", "lens_array", "lenticule", "names", "optics", "profiles", "provenance", "sheets", "turned"}
ROOMS = {
    "archive",
    "attest",
    "bench",
    "calibration",
    "cli",
    "designer",
    "evaluation",
    "fabrication",
    "idcodes",
    "looks",
    "registry",
    "sandbox",
    "simulate",
    "verifier",
    "watch",
    "web",
}
MAY_IMPORT = {
    "ground": GROUND,
    "idcodes": GROUND,
    "designer": GROUND | {"idcodes"},
    "fabrication": GROUND | {"looks"},
    "looks": GROUND,
    "simulate": GROUND,
    "verifier": GROUND | {"idcodes"},
    "calibration": GROUND | {"verifier"},
    "registry": GROUND,
    # It judges in the sandbox, and signs outside of it.
    "attest": GROUND | {"sandbox", "verifier"},
    "evaluation": GROUND | {"archive", "registry", "verifier"},
    # The bench plays all parts: it prints, films and verifies.  Nobody but the command line may lean on it.
    "bench": GROUND | ROOMS - {"cli", "web"},
    "cli": GROUND | ROOMS,
    "web": GROUND | ROOMS,
    # It judges in the sandbox, and hands on bytes and addresses.
    "watch": GROUND | {"sandbox", "verifier"},
    # The engine knows nothing of what is done with films: others hand it their work.
    "archive": GROUND | {"sandbox"},
    # It knows nothing of what is done within.
    "sandbox": {"errors"},
}
#: Rooms inside rooms: which folders and files beside it in its room a folder may import.  Data flows one way, so a
#: folder never imports one that stands below it here.
WITHIN: dict[str, set[str]] = {
    "verifier.tracking": {"picture"},
    "verifier.tracking.finding": {"picture"},
    "verifier.camera": {"limits", "measuring", "series", "splines"},
    "verifier.fringes": {"tracking", "camera", "limits", "measuring", "series"},
    "verifier.explanations": {"fringes", "camera", "limits", "measuring", "reasons", "series", "splines"},
    "verifier.explanations.photographs": {"fringes", "camera", "limits", "measuring", "reasons", "series", "splines"},
    "verifier.decision": {"explanations", "fringes", "camera", "limits", "measuring", "reasons", "series"},
    "verifier.identity": {"tracking", "fringes", "explanations", "decision", "limits", "measuring", "reasons"},
    "verifier.session": {
        "tracking",
        "camera",
        "fringes",
        "explanations",
        "decision",
        "identity",
        "limits",
        "measuring",
        "reasons",
        "timeline",
        "picture",
        "video",
    },
    "verifier.report": {"camera", "explanations", "decision", "identity", "session", "limits", "measuring", "video"},
    "verifier.live": {"tracking", "fringes", "session", "limits", "measuring", "reasons", "timeline", "picture"},
    "evaluation.baseline": set(),
    "simulate.analytic": {"cameras", "compiled", "light", "motion", "scene"},
    "simulate.mitsuba": {"analytic", "light", "scene"},
    "simulate.recording": {"analytic", "cameras", "compiled", "motion", "scene"},
    "simulate.forgeries": {"analytic", "cameras", "motion", "scene"},
    "simulate.effects": {"light", "motion", "recording", "scene"},
    "fabrication.page": {"sight"},
    "fabrication.printed": {"meshes", "process", "sight", "solids"},
    "fabrication.acrylic": {"page", "meshes", "process", "sight", "solids"},
    "fabrication.assembly": {"page", "printed", "acrylic", "process", "sight"},
    "registry.checkpoints": {"canonical", "keys", "ledger", "log", "record", "schema"},
    "registry.signing": {"canonical", "keys", "log"},
    "registry.transfer": {
        "actor",
        "audit",
        "batch",
        "canonical",
        "engine",
        "keys",
        "ledger",
        "log",
        "look_alikes",
        "record",
        "schema",
        "signing",
        "url",
        "upkeep",
    },
    "registry.bundle": {
        "canonical",
        "checkpoints",
        "keys",
        "ledger",
        "log",
        "look_alikes",
        "record",
        "schema",
        "url",
    },
    "registry.face": {
        "bundle",
        "canonical",
        "checkpoints",
        "claims",
        "ledger",
        "look_alikes",
        "record",
        "schema",
        "upkeep",
    },
    "registry.upkeep": {
        "actor",
        "canonical",
        "claims",
        "engine",
        "keys",
        "ledger",
        "log",
        "look_alikes",
        "record",
        "schema",
        "signing",
    },
    "cli.registry": {"common"},
    "bench.identity": {"rows"},
    "bench.fabricate": set(),
    "bench.simulate": set(),
    "bench.stability": {"identity", "simulate", "rows"},
    "bench.verify": {"rows"},
    "bench.forgers": {"rows", "verdicts"},
    "bench.reality": {"rows", "verdicts"},
    "bench.natural": {"rows"},
    "bench.live": set(),
    "bench.published": {"film_set", "rows"},
    "cli.attest": {"common"},
    "cli.printing": {"common", "issue_notes"},
    "cli.verify": {"attest", "common"},
    "cli.watch": {"verify", "common"},
    "web.store": {"problems", "settings"},
    "web.auth": {"store", "problems", "settings", "studio"},
    "web.door": {"auth", "store", "problems", "settings"},
    "web.jobs": {"auth", "door", "store", "problems", "settings"},
    "web.api": {
        *("auth", "jobs", "store", "checks", "forms", "issue_jobs", "pictures", "problems", "reports", "studio"),
        "uploads",
    },
    "web.pages": {
        *("auth", "jobs", "store", "checks", "forms", "issue_jobs", "pictures", "problems", "reports", "samples"),
        *("studio", "uploads"),
    },
    "web.live": {"auth", "jobs", "pages", "checks", "forms", "links", "problems", "store", "studio"},
}
#: Files of a folder beside its `__init__`; a folder with more is several.
MOST_FILES = 15
#: `build123d` alone takes 5 s to import, so no module of ours may import these where it is merely loaded.
HEAVY = {
    "OCP",
    "build123d",
    "cadquery",
    "dask",
    "distributed",
    "drjit",
    "fsspec",
    "manifold3d",
    "mitsuba",
    "pyarrow",
    "trimesh",
}
#: Imports that only a type checker sees.
CHECKER_ONLY = {"TYPE_CHECKING", "typing.TYPE_CHECKING"}


def room_of(module: str) -> str:
    """The room of a module by its dotted name: moireid.verifier.video -> verifier, moireid.badge -> ground."""
    parts = module.split(".")
    return parts[1] if len(parts) > 1 and parts[1] in ROOMS else "ground"


def imports(tree: ast.AST, module: str, *, package: bool) -> Iterator[str]:
    """Every dotted name that a module imports, anywhere in it; `from x import y` gives x and x.y."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = module.split(".")
            base = base[: len(base) - node.level + package] if node.level else []
            origin = ".".join([*base, node.module] if node.module else base)
            yield origin
            yield from (f"{origin}.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.Call):
            # importlib.import_module("moireid.simulate") would be a way round.
            called = ast.unparse(node.func).rsplit(".", 1)[-1]
            if called in ("import_module", "__import__"):
                yield from (a.value for a in node.args if isinstance(a, ast.Constant) and isinstance(a.value, str))


def own_imports(tree: ast.AST, module: str, *, package: bool = False) -> set[str]:
    """Names on moireid's second level that a module imports: rooms, and files of the ground."""
    names = {name.split(".")[1] for name in imports(tree, module, package=package) if name.startswith("moireid.")}
    return {name for name in names if name in ROOMS or (ROOT / f"{name}.py").exists() or name in GROUND}


def at_loading(body: list[ast.stmt]) -> Iterator[ast.stmt]:
    """The statements that run when a module is loaded: not those in functions, nor those for type checkers."""
    for node in body:
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
            continue
        if isinstance(node, ast.If) and ast.unparse(node.test) in CHECKER_ONLY:
            yield from at_loading(node.orelse)
            continue
        yield node
        for part in ("body", "orelse", "finalbody"):
            yield from at_loading(getattr(node, part, []))
        for handler in getattr(node, "handlers", []):
            yield from at_loading(handler.body)


def loaded_packages(tree: ast.Module) -> set[str]:
    """Top-level packages that are imported by merely loading a module."""
    found = set()
    for node in at_loading(tree.body):
        if isinstance(node, ast.Import):
            found |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and not node.level:
            found.add((node.module or "").split(".")[0])
    return found


def modules() -> list[tuple[str, Path]]:
    """Every module of ours with its dotted name."""
    found = []
    for path in sorted(ROOT.rglob("*.py")):
        parts = ["moireid", *path.relative_to(ROOT).with_suffix("").parts]
        found.append((".".join(parts[:-1] if parts[-1] == "__init__" else parts), path))
    return found


def parse(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"), filename=str(path))


@pytest.mark.parametrize("room", MAY_IMPORT)
def test_a_room_imports_only_what_it_may(room: str) -> None:
    """Catches: a verifier that leans on the simulator, a registry that designs, an import of one room by another."""
    broken = []
    for name, path in modules():
        if room_of(name) != room:
            continue
        allowed = MAY_IMPORT[room] | {room}
        found = own_imports(parse(path), name, package=path.name == "__init__.py")
        broken += [f"{name} imports {other}" for other in sorted(found - allowed)]
    assert broken == []


def reached(graph: dict[str, set[str]], start: str) -> set[str]:
    """The modules that one imports, and those that they import, and so on."""
    found, todo = set[str](), [start]
    while todo:
        new = graph[todo.pop()] - found
        found |= new
        todo += new
    return found


def direct_imports(tree: ast.AST, module: str, known: set[str], *, package: bool = False) -> set[str]:
    """The modules of `known` that a module imports, wherever in it; `from package import module` is of the module."""
    found = set()
    for node in ast.walk(tree):
        if isinstance(node, (ast.Import, ast.ImportFrom, ast.Call)):
            names = set(imports(node, module, package=package)) & known
            found |= {name for name in names if not any(other.startswith(f"{name}.") for other in names)}
    return found


def test_no_modules_import_each_other_in_a_circle() -> None:
    """Catches: a circle that an import in a function, or one for type checkers, hides from Python."""
    paths = dict(modules())
    graph = {
        name: direct_imports(parse(path), name, set(paths), package=path.name == "__init__.py")
        for name, path in paths.items()
    }
    assert [name for name in graph if name in reached(graph, name)] == []


@pytest.mark.parametrize(
    ("source", "found"),
    [
        ("def f():\n    from moireid.a import g", {"moireid.a"}),
        ("if TYPE_CHECKING:\n    from moireid import a", {"moireid.a"}),
        ("from moireid import a\nfrom moireid import __version__", {"moireid", "moireid.a"}),
        ("import moireid.a.b as c", {"moireid.a.b"}),
        ("importlib.import_module('moireid.a.b')", {"moireid.a.b"}),
        ("from .a import b", {"moireid.a.b"}),
        ("import numpy", set()),
    ],
)
def test_the_walk_for_circles_sees_every_import(source: str, found: set[str]) -> None:
    """Catches: a walk that overlooks imports that are nested, relative or for checkers, and so finds no circle."""
    known = {"moireid", "moireid.a", "moireid.a.b", "moireid.c"}
    assert direct_imports(ast.parse(source), "moireid.c", known) == found


def siblings(tree: ast.AST, module: str, folder: str) -> set[str]:
    """Folders and files of the same room, outside its own folder, that a module imports."""
    room = f"moireid.{folder.split('.')[0]}."
    names = {name for name in imports(tree, module, package=False) if name.startswith(room)}
    found = {name.removeprefix(room).split(".")[0] for name in names} - {folder.split(".")[1]}
    place = ROOT / folder.split(".")[0]
    return {name for name in found if (place / name).is_dir() or (place / f"{name}.py").exists()}


@pytest.mark.parametrize("folder", WITHIN)
def test_a_folder_imports_only_what_it_may(folder: str) -> None:
    """Catches: tracking that looks at poses, a camera that looks at fringes, a step that reaches forward."""
    paths = sorted((ROOT / folder.replace(".", "/")).rglob("*.py"))
    assert paths
    broken = []
    for path in paths:
        name = ".".join(["moireid", *path.relative_to(ROOT).with_suffix("").parts])
        broken += [f"{name} imports {other}" for other in siblings(parse(path), name, folder) - WITHIN[folder]]
    assert broken == []


def test_every_folder_within_a_room_has_rules_and_a_map() -> None:
    """Catches: a folder without rules, one that grew beyond what can be overlooked, a map that forgets a file."""
    folders = [path.parent for path in ROOT.rglob("__init__.py") if path.parent != ROOT]
    inner = {".".join(folder.relative_to(ROOT).parts) for folder in folders if len(folder.relative_to(ROOT).parts) > 1}
    assert inner == set(WITHIN)
    for folder in folders:
        files = {path.name for path in folder.glob("*.py")} - {"__init__.py"}
        assert len(files) <= MOST_FILES, folder
        text = (folder / "__init__.py").read_text(encoding="utf-8")
        parts = files | {f"{path.parent.name}/" for path in folder.glob("*/__init__.py")}
        assert {part for part in parts if part not in text} == set(), folder


def test_every_folder_is_a_room_with_rules() -> None:
    """Catches: a new room that nobody wrote rules for, which the test above would pass over."""
    folders = {path.parent.name for path in ROOT.glob("*/__init__.py")}
    assert folders <= set(MAY_IMPORT)
    assert {"verifier", "simulate", "fabrication", "registry", "designer", "idcodes", "cli"} <= folders
    files = {path.stem for path in ROOT.glob("*.py")} - {"__init__", "__main__"}
    assert files <= GROUND


def test_heavy_packages_are_imported_within_functions_only() -> None:
    """Catches: `import build123d` at the top of a module that a verify or a --help loads."""
    broken = {name: sorted(loaded_packages(parse(path)) & HEAVY) for name, path in modules()}
    assert {name: found for name, found in broken.items() if found} == {}


@pytest.mark.parametrize(
    ("source", "found"),
    [
        ("import moireid.simulate.filming", {"simulate"}),
        ("from moireid import simulate", {"simulate"}),
        ("from moireid.simulate import filming", {"simulate"}),
        ("from ..simulate.filming import film", {"simulate"}),
        ("from .. import fabrication, badge", {"fabrication", "badge"}),
        ("from . import track", {"verifier"}),
        ("def f():\n    from moireid.fabrication.page.pdf import Sheet", {"fabrication"}),
        (
            "if True:\n    try:\n        import moireid.registry as r\n    except ImportError:\n        pass",
            {"registry"},
        ),
        ("import importlib\nimportlib.import_module('moireid.simulate.forgeries.courses')", {"simulate"}),
        ("from moireid import __version__\nimport numpy.simulate", set()),
    ],
)
def test_the_walk_sees_every_way_of_importing(source: str, found: set[str]) -> None:
    """Catches: a walk that overlooks relative, nested, renamed or spelled-out imports, and so can never fail."""
    assert own_imports(ast.parse(source), "moireid.verifier.video") == found


@pytest.mark.parametrize(
    ("source", "found"),
    [
        ("import build123d as b", {"build123d"}),
        ("try:\n    import mitsuba\nexcept ImportError:\n    import cadquery.func", {"mitsuba", "cadquery"}),
        ("class A:\n    from build123d import Box", {"build123d"}),
        ("with x:\n    import trimesh", {"trimesh"}),
        ("def f():\n    import mitsuba\nclass A:\n    def g(self):\n        import cadquery", set()),
        ("if TYPE_CHECKING:\n    import mitsuba\nelse:\n    import drjit", {"drjit"}),
    ],
)
def test_the_walk_tells_loading_from_calling(source: str, found: set[str]) -> None:
    """Catches: a walk that takes an import in a function for one at the top, or one in a class for none."""
    assert loaded_packages(ast.parse(source)) & HEAVY == found


def test_the_verifier_at_work_loads_neither_simulator_nor_workshop() -> None:
    """Catches: an import by way of a third module, which the rules for single files let through."""
    code = (
        "import sys\n"
        "import moireid.verifier, moireid.verifier.session.identify, moireid.verifier.report.page, moireid.registry\n"
        "print(*sorted(m for m in sys.modules if m.startswith(('moireid.simulate', 'moireid.fabrication', "
        "'build123d', 'mitsuba', 'cadquery', 'trimesh', 'numba', 'matplotlib'))))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == []


def test_the_command_knows_the_forgeries_of_the_simulator() -> None:
    """Catches: a forgery that --forge does not offer, or offers and nobody can make (the list is written twice)."""
    assert FORGERIES == KINDS
    assert len(set(KINDS)) == len(KINDS)
