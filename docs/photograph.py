"""A photograph of a badge as it is worn, path-traced in colour, for README and gallery; it is no evidence of anything.

Holder, hook, cord and cloth are grids of points around the simulator's own mesh of page and lenses.

Convention: board frame of `moireid.simulate.motion`, mm; a grid (rows, columns, 3) is a surface that joins neighbouring
points.  Colours are linear red, green, blue.
Source: Mitsuba 3.9.1, plugins `path`, `thinlens`, `diffuse`, `roughplastic`, `roughconductor`, `bumpmap`, `bitmap`;
IEC 61966-2-1 for sRGB.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from scipy.ndimage import gaussian_filter

from moireid.badge import load_badge
from moireid.frames import own_frame
from moireid.simulate.build import build_named
from moireid.simulate.mitsuba.mitsuba_renderer import grating_parts
from moireid.simulate.mitsuba.scene_parts import clear, mesh
from moireid.simulate.mitsuba.sheet import ACROSS, ALONG, BEHIND_MM, Strips
from moireid.simulate.mitsuba.variant import loaded_mitsuba
from moireid.simulate.scene import Scene
from moireid.simulate.settings.wearing import load_print

Array = NDArray[np.float64]
Colour = tuple[float, float, float]
WIDTH, HEIGHT = 600, 800
#: Faces that a ray may meet: through a lens to the page and out again, and through a second lens; chords of each lens.
MOST_FACES, SEGMENTS = 14, 12
#: Share of the picture's height that the badge takes, and its height above the picture's middle as a share of its own.
SHARE, RAISED = 0.60, 0.20
#: The camera: its distance, mm, how far it is to the right and above, degrees, and its opening's radius, mm.
DISTANCE_MM, ASIDE_DEG, ABOVE_DEG, OPENING_MM = 800.0, 14.0, 6.0, 6.0
#: The soft light: half of its side, its distance, mm, and where it is; its radiance, and the room's.
LAMP_HALF_MM, LAMP_MM, LAMP_DIRECTION = 600.0, 1500.0, (-0.70, -0.58, -0.42)
LAMP, ROOM = (5.6, 5.4, 5.0), (0.30, 0.32, 0.36)
#: Half of what the cloth covers, and how far it is behind the page, mm.
CLOTH_HALF_MM, CLOTH_MM = (215.0, 300.0), 9.0
#: Rim and lip of the holder, rounding of its corners, and its depth behind the page, mm.
RIM_MM, LIP_MM, ROUND_MM, BACK_MM, CORD_MM = 3.6, 0.8, 3.0, 4.0, 15.0
WOOL, CORD, MARK = (0.055, 0.085, 0.13), (0.55, 0.07, 0.05), (0.80, 0.76, 0.70)
BLACK, PLASTIC = (0.004, 0.004, 0.004), (0.02, 0.021, 0.024)
#: Points on a quarter of a circle.
QUARTER = 8


def photograph(badge_json: Path, rays: int) -> Image.Image:
    """The badge with the print of preview.png next to it, on a person; some minutes of work."""
    scene = Scene(load_badge(badge_json), build_named("typical", 0), print_picture=load_print(badge_json))
    with loaded_mitsuba() as mi:
        world = mi.load_dict({"type": "scene"} | _badge(mi, scene) | _worn(mi, scene) | _lights(mi))
        followed = mi.load_dict({"type": "path", "max_depth": MOST_FACES, "rr_depth": 8})
        light = np.array(mi.render(world, sensor=mi.load_dict(_sensor(mi, scene)), integrator=followed, spp=rays))
    # Bright parts are compressed rather than cut, and coded as sRGB.
    soft = np.where(light > 0.8, 0.8 + 0.2 * np.tanh((light - 0.8) / 0.4), light)
    coded = np.where(soft <= 0.0031308, 12.92 * soft, 1.055 * np.maximum(soft, 1e-9) ** (1 / 2.4) - 0.055)
    return Image.fromarray(np.rint(255 * np.clip(coded, 0, 1)).astype(np.uint8))


def _lights(mi: Any) -> dict[str, Any]:
    """A large soft lamp above on the left, and a bright room."""
    way = np.array(LAMP_DIRECTION) / np.linalg.norm(LAMP_DIRECTION)
    facing = mi.ScalarTransform4f().look_at(origin=list(LAMP_MM * way), target=[0.0, 0.0, 0.0], up=[0.0, -1.0, 0.0])
    size = mi.ScalarTransform4f().scale([LAMP_HALF_MM, LAMP_HALF_MM, 1.0])
    shines = {"type": "area", "radiance": _rgb(LAMP)}
    return {
        "lamp": {"type": "rectangle", "to_world": facing @ size, "emitter": shines},
        "room": {"type": "constant", "radiance": _rgb(ROOM)},
    }


def _sensor(mi: Any, scene: Scene) -> dict[str, Any]:
    """The camera, focused on the badge, which is a little below the picture's middle."""
    high = 2 * (scene.board_half_mm[1] + RIM_MM)
    aside, above = math.radians(ASIDE_DEG), math.radians(ABOVE_DEG)
    way = np.array([math.sin(aside) * math.cos(above), -math.sin(above), -math.cos(aside) * math.cos(above)])
    origin, target = (DISTANCE_MM * way).tolist(), [0.0, -RAISED * high, 0.0]
    return {
        "type": "thinlens",
        "fov_axis": "y",
        "fov": math.degrees(2 * math.atan(high / SHARE / 2 / DISTANCE_MM)),
        "aperture_radius": OPENING_MM,
        "focus_distance": DISTANCE_MM,
        "near_clip": 10.0,
        "far_clip": 10 * DISTANCE_MM,
        "to_world": mi.ScalarTransform4f().look_at(origin=origin, target=target, up=[0.0, -1.0, 0.0]),
        "sampler": {"type": "independent"},
        "film": {"type": "hdrfilm", "width": WIDTH, "height": HEIGHT, "pixel_format": "rgb"},
    }


def _badge(mi: Any, scene: Scene) -> dict[str, Any]:
    """The page in colour just behind the lines' own strips, and the lens sheets over the lines."""
    half = scene.board_half_mm
    across, along = (np.array([[-side, side]])[:, list(turn)] for side, turn in ((half[0], ACROSS), (half[1], ALONG)))
    places = np.stack([np.array(ACROSS), np.array(ALONG)], axis=-1).astype(float)
    assert scene.print_picture is not None
    strips = Strips(across, along, np.full(across.shape, BEHIND_MM))
    printed = _pictured(mi, np.ascontiguousarray(scene.print_picture[..., ::-1]))
    page = mesh(mi, own_frame("x", scene.badge.page_mm), strips, {"bsdf": printed}, places=places[None])
    described = {"page": page}
    surfaces = {
        "ink": {"bsdf": _matt(mi, (scene.ink,) * 3)},
        "paper": {"bsdf": _matt(mi, (scene.paper,) * 3)},
        "glass": clear(mi, scene.lens.refractive_index),
        "bars": {"bsdf": _matt(mi, (scene.ink,) * 3)},
        "walls": {"bsdf": _matt(mi, (0.7,) * 3)},
    }
    for number in range(len(scene.badge.gratings)):
        for part, made in grating_parts(mi, scene, number, SEGMENTS, surfaces).items():
            described[f"grating{number}_{part}"] = made
    return described


def _worn(mi: Any, scene: Scene) -> dict[str, Any]:
    """Holder, hook, cord and cloth around the board."""
    (x, y), front = scene.board_half_mm, -scene.height_mm
    plastic = mi.load_dict({"type": "roughplastic", "diffuse_reflectance": _rgb(PLASTIC), "alpha": 0.12})
    metal = mi.load_dict({"type": "roughconductor", "material": "Cr", "alpha": 0.15})
    lip = [(-LIP_MM, 0.0), (-LIP_MM, front - 0.3), (-LIP_MM + 0.3, front - 0.7), (0.6, front - 1.2)]
    lip += [(RIM_MM - 0.8, front - 1.2), (RIM_MM - 0.2, front - 0.9), (RIM_MM, front - 0.2), (RIM_MM, BACK_MM)]
    top = -y - RIM_MM
    turn = np.linspace(-0.25, 1.3, 40) * 2 * np.pi
    hook = np.column_stack([4.2 * np.sin(turn), top - 10.5 - 5.6 * np.cos(turn), -2.6 + 1.4 * np.cos(turn)])
    turn = np.linspace(0, 2 * np.pi, 40)
    ring = np.column_stack([5.0 * np.cos(turn), top - 19.5 + 3.4 * np.sin(turn), np.full(len(turn), -1.6)])
    cloth = _chest()
    described = {
        "holder": _grid(mi, _rings((x, y), ROUND_MM, lip), plastic),
        "back": _grid(mi, _plate((x + RIM_MM, y + RIM_MM), ROUND_MM, BACK_MM - 1, BACK_MM), plastic),
        "tab": _grid(mi, _plate((13.0, 7.0), 4.0, front - 0.6, BACK_MM, top - 4.0), plastic),
        "slot": _grid(mi, _plate((7.0, 1.8), 1.8, front - 0.7, front, top - 6.5), _matt(mi, BLACK)),
        "hook": _grid(mi, _tube(hook, 1.1), metal),
        "ring": _grid(mi, _tube(ring, 1.0), metal),
        "crimp": _grid(mi, _plate((9.0, 5.5), 1.2, -3.2, 3.0, top - 27.0), metal),
        "cloth": _grid(mi, cloth, _wool(mi)),
    }
    for side in (-1, 1):
        path = _cord_path(cloth, side, top - 27.0)
        described[f"cord{side}"] = _grid(mi, _ribbon(path), _woven(mi, path))
    return described


def _rings(half_mm: tuple[float, float], radius_mm: float, profile: list[tuple[float, float]]) -> Array:
    """A surface through rounded rectangles, one for each (offset, depth) of the profile."""
    turn, made = np.linspace(0, math.pi / 2, QUARTER + 1), []
    for offset, depth in profile:
        half = half_mm[0] + offset, half_mm[1] + offset
        radius = min(max(radius_mm + offset, 0.05), *half)
        angle = np.concatenate([turn + k * math.pi / 2 for k in range(4)])
        middle = np.repeat([(1, 1), (-1, 1), (-1, -1), (1, -1)], QUARTER + 1, axis=0) * (np.array(half) - radius)
        outline = middle + radius * np.column_stack([np.cos(angle), np.sin(angle)])
        outline = np.vstack([outline, outline[:1]])
        made.append(np.column_stack([outline, np.full(len(outline), depth)]))
    return np.stack(made)


def _plate(half_mm: tuple[float, float], radius_mm: float, front: float, back: float, middle_y: float = 0.0) -> Array:
    """A plate with rounded corners and edges, its front and its back at two depths."""
    profile = [(-0.98 * min(half_mm), front), (-0.6, front), (-0.2, front + 0.2), (0.0, front + 0.6), (0.0, back)]
    return _rings(half_mm, radius_mm, profile) + np.array([0.0, middle_y, 0.0])


def _tube(path: Array, radius_mm: float) -> Array:
    """A tube about a path (N, 3), no part of which runs along (0.31, 0.17, 0.94)."""
    way = np.gradient(path, axis=0)
    aside = np.cross(way, np.array([0.31, 0.17, 0.94]))
    other = np.cross(way, aside)
    aside, other = (one / np.linalg.norm(one, axis=1, keepdims=True) for one in (aside, other))
    turn = np.linspace(0, 2 * math.pi, 4 * QUARTER + 1)[None, :, None]
    return path[:, None] + radius_mm * (np.cos(turn) * aside[:, None] + np.sin(turn) * other[:, None])


def _chest() -> Array:
    """The cloth of a chest: rounder across than along, with folds that hang from the shoulders."""
    x, y = np.meshgrid(*(np.arange(-half, half + 1.0, 1.5) for half in CLOTH_HALF_MM))
    body = 165.0 * (1 - np.sqrt(np.clip(1 - (x / 230.0) ** 2, 0.05, 1))) + 0.0006 * np.minimum(y + 40, 0) ** 2
    rng, folds = np.random.default_rng(0), np.zeros_like(body)
    for along, across, height in ((70.0, 15.0, 5.0), (110.0, 30.0, 9.0), (20.0, 20.0, 1.2)):
        noise = gaussian_filter(rng.standard_normal(body.shape), (along / 1.5, across / 1.5))
        folds += height * noise / noise.std()
    depth = CLOTH_MM + body + np.abs(folds) * 0.8 + 0.2 * folds
    return np.stack([x, y, depth - max(0.0, CLOTH_MM - depth.min())], axis=-1)


def _wool(mi: Any) -> Any:
    """A knitted jumper: stitches, each a V of two strands, as small slopes, and darker between them."""
    x, y = np.meshgrid(*(np.arange(10 * half) / 5 for half in CLOTH_HALF_MM))
    across = np.abs((x / 2.6) % 1.0 - 0.5) * 2
    along = (y / 2.0 + 0.9 * (1 - across)) % 1.0
    height = np.sin(math.pi * along) ** 0.7 * np.sin(math.pi * np.clip(across * 0.9 + 0.05, 0, 1)) ** 0.5
    # Yarn is never of one colour throughout.
    yarn = np.random.default_rng(1).normal(1.0, 0.10, (height.shape[0] // 4 + 1, height.shape[1] // 4 + 1))
    uneven = np.kron(yarn, np.ones((4, 4)))[: height.shape[0], : height.shape[1]]
    colour = np.multiply.outer((0.35 + 0.65 * height) * np.clip(uneven, 0.6, 1.4), np.array(WOOL)).astype(np.float32)
    bumps = mi.Bitmap(height.astype(np.float32)[..., None])
    bsdf = {
        "type": "bumpmap",
        "scale": 0.8,
        "height": {"type": "bitmap", "bitmap": bumps, "raw": True},
        "nested": {"type": "diffuse", "reflectance": _texture(mi, colour)},
    }
    return mi.load_dict({"type": "twosided", "bsdf": bsdf})


def _cord_path(cloth: Array, side: int, foot: float) -> Array:
    """One half of the cord, from the crimp to a shoulder; it is taut, so it bridges the folds of the cloth."""
    share = np.linspace(0.0, 1.0, 60)
    x, y = side * (3.0 + 92.0 * share**1.15), foot - 230.0 * share
    rows, columns = (np.rint((place - cloth[0, 0, k]) / 1.5).astype(int) for k, place in ((1, y), (0, x)))
    rests = cloth[np.clip(rows, 0, cloth.shape[0] - 1), columns, 2] - 1.2
    taut = np.minimum(rests, np.convolve(np.pad(rests, 8, mode="edge"), np.ones(17) / 17, mode="valid"))
    rising = np.clip(share / 0.35, 0, 1)
    return np.column_stack([x, y, -0.3 * side + (taut + 0.3 * side) * rising**2 * (3 - 2 * rising)])


def _ribbon(path: Array) -> Array:
    """The flat cord along its path, its edges bent back a little, so that they catch the light."""
    way = np.gradient(path, axis=0)
    across = np.column_stack([-way[:, 1], way[:, 0], np.zeros(len(way))])
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    side = np.array([-0.5, 0.0, 0.5])[None, :, None] * CORD_MM * across[:, None]
    side[..., 2] += np.array([0.5, 0.0, 0.5])
    return path[:, None] + side


def _woven(mi: Any, path: Array) -> Any:
    """Woven cord with a mark that is repeated along it."""
    length, per_mm = float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum()), 8
    y, x = np.mgrid[0 : int(length * per_mm), 0 : int(CORD_MM * per_mm)] / per_mm
    weave = 0.86 + 0.14 * np.sin(2 * np.pi * (x + y) / 0.9) * np.sin(2 * np.pi * (x - y) / 0.9)
    distance = np.hypot(x - CORD_MM / 2, (y - 20.0) % 34.0 - 17.0)
    ringed = ((distance < 4.0) & (distance > 2.8)) | (distance < 1.5)
    picture = weave[..., None] * np.where(ringed[..., None], MARK, CORD)
    picture[(x < 0.8) | (x > CORD_MM - 0.8)] *= 0.8
    return _pictured(mi, picture.astype(np.float32))


def _grid(mi: Any, points: Array, bsdf: Any) -> Any:
    """A grid of points as a surface; its texture spans it, columns to the right and rows down."""
    rows, columns = points.shape[:2]
    corner = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    upper = np.column_stack([corner, corner + 1, corner + columns])
    lower = np.column_stack([corner + 1, corner + columns + 1, corner + columns])
    props = mi.Properties()
    props["bsdf"] = bsdf
    faces, u, v = np.concatenate([upper, lower]), *np.meshgrid(np.linspace(0, 1, columns), np.linspace(0, 1, rows))
    made = mi.Mesh("grid", rows * columns, len(faces), props=props, has_vertex_normals=False, has_vertex_texcoords=True)
    figures = mi.traverse(made)
    figures["vertex_positions"] = points.astype(np.float32).ravel()
    figures["faces"] = faces.astype(np.uint32).ravel()
    figures["vertex_texcoords"] = np.stack([u, v], axis=-1).astype(np.float32).ravel()
    figures.update()
    return made


def _matt(mi: Any, colour: Colour) -> Any:
    return mi.load_dict({"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": _rgb(colour)}})


def _pictured(mi: Any, picture: NDArray[Any]) -> Any:
    """A matt surface of a picture (rows, columns, 3): of bytes as coded for a screen, of floats as linear light."""
    return mi.load_dict({"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": _texture(mi, picture)}})


def _texture(mi: Any, picture: NDArray[Any]) -> dict[str, Any]:
    return {"type": "bitmap", "bitmap": mi.Bitmap(picture), "raw": False, "wrap_mode": "clamp"}


def _rgb(colour: Colour) -> dict[str, Any]:
    return {"type": "rgb", "value": list(colour)}
