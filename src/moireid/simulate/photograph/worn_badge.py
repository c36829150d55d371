"""What is around a badge that is worn: holder, hook, cord and cloth, as Mitsuba's surfaces; and the badge in colour.

Convention: board frame of `motion`, mm.  Colours are linear red, green, blue.
Source: Mitsuba 3.9.1, plugins `diffuse`, `roughplastic`, `roughconductor`, `dielectric`, `bumpmap`, `bitmap`.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from moireid.frames import own_frame
from moireid.simulate.mitsuba.mitsuba_renderer import grating_parts
from moireid.simulate.mitsuba.scene_parts import clear, mesh
from moireid.simulate.mitsuba.sheet import ACROSS, ALONG, BEHIND_MM, Strips
from moireid.simulate.photograph.surfaces import Cloth, knit, plate, ribbon, rings, tube
from moireid.simulate.scene import Scene

Array = NDArray[np.float64]
Colour = tuple[float, float, float]
#: Half of what the cloth covers, and how far it is behind the page, mm.
CLOTH_HALF_MM, CLOTH_MM = (215.0, 300.0), 9.0
#: Rim and lip of the holder, rounding of its corners, and its depth behind the page, mm.
RIM_MM, LIP_MM, ROUND_MM, BACK_MM = 3.6, 0.8, 3.0, 4.0
CORD_MM = 15.0
WOOL: Colour = (0.055, 0.085, 0.13)
CORD: Colour = (0.55, 0.07, 0.05)
MARK: Colour = (0.80, 0.76, 0.70)
BLACK: Colour = (0.004, 0.004, 0.004)
PLASTIC: Colour = (0.02, 0.021, 0.024)
#: Height of a stitch.
STITCH_MM = 0.8
#: Chords of each lens.
SEGMENTS = 12


def badge_surfaces(mi: Any, scene: Scene) -> dict[str, Any]:
    """The printed page, and the lens sheets over its lines, lit from outside."""
    described = {"page": _page(mi, scene)}
    for number in range(len(scene.badge.gratings)):
        surfaces = {
            "ink": _matt(mi, (scene.ink,) * 3),
            "paper": _matt(mi, (scene.paper,) * 3),
            "glass": clear(mi, scene.lens.refractive_index),
            "bars": _matt(mi, (scene.ink,) * 3),
            "walls": _matt(mi, (0.7,) * 3),
        }
        bare = replace(scene, need=replace(scene.need, bounces=False))
        for part, made in grating_parts(mi, bare, number, SEGMENTS, surfaces).items():
            described[f"grating{number}_{part}"] = made
    return described


def _page(mi: Any, scene: Scene) -> Any:
    """The print in colour over the whole board, just behind the lines' own strips."""
    half = scene.board_half_mm
    across, along = (np.array([[-side, side]])[:, list(turn)] for side, turn in ((half[0], ACROSS), (half[1], ALONG)))
    places = np.stack([np.array(ACROSS), np.array(ALONG)], axis=-1).astype(float)
    printed = scene.print_picture
    if printed is None:
        bsdf = _matt(mi, (scene.paper,) * 3)["bsdf"]
    else:
        bsdf = _pictured(mi, np.ascontiguousarray(printed[..., ::-1]))
    strips = Strips(across, along, np.full(across.shape, BEHIND_MM))
    return mesh(mi, own_frame("x", scene.badge.page_mm), strips, {"bsdf": bsdf}, places=places[None])


def worn_surfaces(mi: Any, scene: Scene, seed: int) -> dict[str, Any]:
    """Holder, hook, cord and cloth around the board."""
    x, y = scene.board_half_mm
    front = -scene.height_mm
    cloth = Cloth(CLOTH_HALF_MM, CLOTH_MM, seed)
    plastic = {"type": "roughplastic", "diffuse_reflectance": _rgb(PLASTIC), "alpha": 0.12}
    metal = {"type": "roughconductor", "material": "Cr", "alpha": 0.15}
    lip = [(-LIP_MM, 0.0), (-LIP_MM, front - 0.3), (-LIP_MM + 0.3, front - 0.7), (0.6, front - 1.2)]
    lip += [(RIM_MM - 0.8, front - 1.2), (RIM_MM - 0.2, front - 0.9), (RIM_MM, front - 0.2), (RIM_MM, BACK_MM)]
    top = -y - RIM_MM
    tab = plate((13.0, 7.0), 4.0, front - 0.6, BACK_MM, middle_y=top - 4.0)
    hook, ring, crimp = _hook(top)
    described = {
        "holder": _grid(mi, rings((x, y), ROUND_MM, lip), mi.load_dict(plastic)),
        "back": _grid(mi, plate((x + RIM_MM, y + RIM_MM), ROUND_MM, BACK_MM - 1, BACK_MM), mi.load_dict(plastic)),
        "tab": _grid(mi, tab, mi.load_dict(plastic)),
        "slot": _grid(mi, plate((7.0, 1.8), 1.8, front - 0.7, front, middle_y=top - 6.5), _matt(mi, BLACK)["bsdf"]),
        "hook": _grid(mi, hook, mi.load_dict(metal)),
        "ring": _grid(mi, ring, mi.load_dict(metal)),
        "crimp": _grid(mi, crimp, mi.load_dict(metal)),
        "cloth": _cloth(mi, cloth),
    }
    for side in (-1, 1):
        path = _cord_path(cloth, side, top - 27.0)
        described[f"cord{side}"] = _grid(mi, ribbon(path, CORD_MM), _cord_surface(mi, path))
    return described


def _hook(top: float) -> tuple[Array, Array, Array]:
    """A hook through the holder's slot, the swivel's ring above it, and the crimp that holds both ends of the cord."""
    turn = np.linspace(-0.25, 1.3, 40) * 2 * np.pi
    loop = np.column_stack([4.2 * np.sin(turn), top - 10.5 - 5.6 * np.cos(turn), -2.6 + 1.4 * np.cos(turn)])
    hook = tube(loop, 1.1)
    turn = np.linspace(0, 2 * np.pi, 40)[:-1]
    ring = tube(
        np.column_stack([5.0 * np.cos(turn), top - 19.5 + 3.4 * np.sin(turn), np.full(len(turn), -1.6)]),
        1.0,
        closed=True,
    )
    crimp = plate((9.0, 5.5), 1.2, -3.2, 3.0, middle_y=top - 27.0)
    return hook, ring, crimp


def _cord_path(cloth: Cloth, side: int, foot: float) -> Array:
    """One half of the cord, from the crimp to a shoulder, resting on the cloth."""
    share = np.linspace(0.0, 1.0, 60)
    places = np.column_stack([side * (3.0 + 92.0 * share**1.15), foot - 230.0 * share])
    rests = cloth.depth_mm(places) - 1.2
    # From the crimp it rises to the chest within a few centimetres; it is taut, so it bridges the folds.
    taut = np.minimum(rests, np.convolve(np.pad(rests, 8, mode="edge"), np.ones(17) / 17, mode="valid"))
    weight = np.clip(share / 0.35, 0, 1) ** 2 * (3 - 2 * np.clip(share / 0.35, 0, 1))
    depth = -0.3 * side + (taut + 0.3 * side) * weight
    return np.column_stack([places, depth])


def _cord_surface(mi: Any, path: Array) -> Any:
    """Woven cord with a mark that is repeated along it."""
    length = float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())
    per_mm = 8
    y, x = np.mgrid[0 : int(length * per_mm), 0 : int(CORD_MM * per_mm)] / per_mm
    weave = 0.86 + 0.14 * np.sin(2 * np.pi * (x + y) / 0.9) * np.sin(2 * np.pi * (x - y) / 0.9)
    picture = np.multiply.outer(weave, np.array(CORD))
    middle = (y - 20.0) % 34.0 - 17.0
    distance = np.hypot(x - CORD_MM / 2, middle)
    ringed = ((distance < 4.0) & (distance > 2.8)) | (distance < 1.5)
    picture[ringed] = np.multiply.outer(weave[ringed], np.array(MARK))
    picture[(x < 0.8) | (x > CORD_MM - 0.8)] *= 0.8
    return _pictured(mi, picture.astype(np.float32))


def _cloth(mi: Any, cloth: Cloth) -> Any:
    """A knitted jumper: stitches as small slopes, and darker between them."""
    height = knit(CLOTH_HALF_MM)
    # Yarn is never of one colour throughout.
    yarn = np.random.default_rng(1).normal(1.0, 0.10, (height.shape[0] // 4 + 1, height.shape[1] // 4 + 1))
    uneven = np.kron(yarn, np.ones((4, 4)))[: height.shape[0], : height.shape[1]]
    colour = np.multiply.outer((0.35 + 0.65 * height) * np.clip(uneven, 0.6, 1.4), np.array(WOOL)).astype(np.float32)
    bumps = mi.Bitmap(height.astype(np.float32)[..., None])
    bsdf = {
        "type": "bumpmap",
        "scale": STITCH_MM,
        "height": {"type": "bitmap", "bitmap": bumps, "raw": True},
        "nested": {"type": "diffuse", "reflectance": _texture(mi, colour)},
    }
    return _grid(mi, cloth.grid(), mi.load_dict({"type": "twosided", "bsdf": bsdf}))


def _grid(mi: Any, points: Array, bsdf: Any) -> Any:
    """A grid of points as a smooth surface; its texture spans it, columns to the right and rows down."""
    rows, columns = points.shape[:2]
    corner = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    faces = np.concatenate(
        [
            np.column_stack([corner, corner + 1, corner + columns]),
            np.column_stack([corner + 1, corner + columns + 1, corner + columns]),
        ]
    )
    props = mi.Properties()
    props["bsdf"] = bsdf
    made = mi.Mesh("grid", rows * columns, len(faces), props=props, has_vertex_normals=False, has_vertex_texcoords=True)
    figures = mi.traverse(made)
    u, v = np.meshgrid(np.linspace(0, 1, columns), np.linspace(0, 1, rows))
    figures["vertex_positions"] = points.astype(np.float32).ravel()
    figures["faces"] = faces.astype(np.uint32).ravel()
    figures["vertex_texcoords"] = np.stack([u, v], axis=-1).astype(np.float32).ravel()
    figures.update()
    return made


def _matt(mi: Any, colour: Colour) -> dict[str, Any]:
    return {"bsdf": mi.load_dict({"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": _rgb(colour)}})}


def _pictured(mi: Any, picture: NDArray[Any]) -> Any:
    """A matt surface of a picture (rows, columns, 3): of bytes as coded for a screen, of floats as linear light."""
    return mi.load_dict({"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": _texture(mi, picture)}})


def _texture(mi: Any, picture: NDArray[Any]) -> dict[str, Any]:
    return {"type": "bitmap", "bitmap": mi.Bitmap(picture), "raw": False, "wrap_mode": "clamp"}


def _rgb(colour: Colour) -> dict[str, Any]:
    return {"type": "rgb", "value": list(colour)}
