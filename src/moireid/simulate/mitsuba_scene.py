"""One frame of the badge by Mitsuba 3: the scene of the analytic renderer as geometry, for a second opinion.

The lens sheet is a mesh of cylinder lenses in smooth segments, refracting by Mitsuba's own dielectric; the printed
lines under it are strips of the page, exact to float32, that shine with the radiance of ink and paper; the rest of the
page is a picture behind them.  Nothing here shares a line of optics with `analytic` or `lenticule`.  What the two have
in common is the description (`Scene`, `Instant`) and the picture of the markers.

The red channel carries the radiance, green the share of it that came through: page and paper shine with 1 in it.  Their
quotient is the mean over the rays that were refracted, so that neither the light that a lens reflects nor the chance by
which Mitsuba picks a ray to reflect shows in the picture.  What stays is that rays count by how much of them passes.

Left out: glare, the direction of the light, the rolling shutter, forgeries.  A ray that leaves the lens through its
neighbour's flank, or that is reflected within, is not followed.

Convention: board frame of `motion`, mm, origin at the board's centre; the lens apex plane is z = -g, the page z = 0.
Mitsuba starts a refracted ray 9e-5 (1 + largest coordinate) away from the surface, so that frame is also the best one
to trace in, and `_page_depth_mm` takes the rest of it back.
Source: Mitsuba 3.9.1, plugins `dielectric`, `area`, `direct`, `perspective`; `shared/physics.md`, Rendering it.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from moireid.badge import Cell, Grating
from moireid.errors import SpecError
from moireid.simulate.analytic import TEXTURE_PX_PER_MM, Rendered, page_texture
from moireid.simulate.mitsuba_variant import mitsuba_with
from moireid.simulate.scene import Instant, Scene

Array = NDArray[np.float64]
Crop = tuple[int, int, int, int]
#: Corners of a strip as (low or high across, begin or end along), turning so that its face looks at the camera.
_ACROSS, _ALONG = (0, 0, 1, 1), (0, 1, 1, 0)
#: Fewer rays than this may all be reflected by the lens, which leaves the pixel without a value.
FEWEST_SAMPLES = 4
#: Mitsuba's own constant: a new ray starts this share of (1 + the largest coordinate) away from its surface.
RAY_OFFSET = 1500 * 2.0**-24
#: The page's picture lies this far behind the printed lines' strips, and deeper than `_page_depth_mm` ever puts them.
BEHIND_MM = 0.02
#: A true film names the middle row's pose as the place of the fringes; between first and last row a hand's course
#: bends less than this (0.004 rad of phase at 1 m).
FORGERY_MM = 0.5


def render_frame(
    scene: Scene, instant: Instant, *, samples: int = 64, segments: int = 16, seed: int = 0, variant: str | None = None,
    crop: Crop | None = None,
) -> Rendered | None:  # fmt: skip
    """Render one frame of the pixels that see the board; None where no pixel does.

    Parameters: samples: rays a pixel, in strata, some counts rounded up; segments: of each cylinder lens; seed: of the
        rays; variant: of Mitsuba, one that ends in `_rgb`, None for the best this machine runs; crop: (left, top,
        right, bottom) px to render, None for the board's own.
    Convention: pixel centres are whole numbers, as in `scene.Camera`; the shutter is global, at the mean of the first
        and the last row's pose; radiance is linear, on the scale of `scene.ink` to `scene.paper`, 0 beside the board.
    Returns: Rendered, to be compared pixel by pixel with `AnalyticRenderer.render`.
    Raises: SpecError for a forgery, a crop beyond the picture, too few rays or segments, or a variant that is none;
        MissingExtraError without mitsuba.
    Source: module docstring.
    """
    _check(scene, samples, segments, seed, crop)
    centre, turn = _middle_pose(instant)
    seen = _board_box(scene, centre, turn)
    if seen is None:
        return None
    box = crop or seen
    with mitsuba_with(variant) as mi:
        described = {"type": "scene", "integrator": _integrator(), "page": _rest_of_page(mi, scene)}
        for number, grating in enumerate(scene.badge.gratings):
            for part, mesh in _grating_meshes(mi, scene, grating, segments).items():
                described[f"grating{number}_{part}"] = mesh
        described["sensor"] = _sensor(mi, scene, centre, turn, box, samples)
        picture = np.array(mi.render(mi.load_dict(described), seed=seed, spp=samples), np.float64)
    coverage = _coverage(scene, centre, turn, box)
    through = picture[..., 1]
    # Where a pixel sees the board but no ray came through (a sheet's open edge), it is taken for paper.
    radiance = np.divide(picture[..., 0], through, out=np.full(through.shape, scene.paper), where=through > 0)
    return Rendered(
        np.where(coverage > 0, radiance, 0.0).astype(np.float32), coverage.astype(np.float32), box[0], box[1]
    )  # fmt: skip


def _check(scene: Scene, samples: int, segments: int, seed: int, crop: Crop | None) -> None:
    """Raise SpecError for figures that make no picture."""
    if samples < FEWEST_SAMPLES or segments < 1 or not 0 <= seed < 2**31:
        raise SpecError(
            f"samples={samples}, segments={segments}, seed={seed} make no picture; give {FEWEST_SAMPLES} samples or "
            "more, 1 segment or more, and a seed of 0 to 2147483647"
        )
    width, height = scene.camera.width, scene.camera.height
    if crop and not (0 <= crop[0] < crop[2] <= width and 0 <= crop[1] < crop[3] <= height):
        raise SpecError(f"crop={crop} must be left < right, top < bottom within the picture's {width} x {height} px")


def _middle_pose(instant: Instant) -> tuple[Array, Array]:
    """Camera centre (3,) mm and rotation board -> camera (3, 3) halfway.  Raises: SpecError for a forged frame."""
    from scipy.spatial.transform import Rotation

    centre = (instant.first.camera_mm[0] + instant.last.camera_mm[0]) / 2
    apart_mm = float(np.linalg.norm(instant.shown_from_mm - centre))
    if apart_mm > FORGERY_MM:
        raise SpecError(
            f"fringes shown from {apart_mm:.3g} mm beside the camera are a forgery, which real lenses cannot show; "
            "render it with AnalyticRenderer",
            apart_mm=apart_mm,
        )
    turns = Rotation.from_matrix(np.stack([instant.first.rotation[0], instant.last.rotation[0]]))
    return np.asarray(centre, float), np.asarray(turns.mean().as_matrix(), float)


def _board_box(scene: Scene, centre: Array, turn: Array) -> Crop | None:
    """Pixels that may see the board, left, top, right, bottom; None where none does."""
    half, camera = np.array(scene.board_half_mm) * scene.build.print_scale, scene.camera
    corners = np.array([[sx * half[0], sy * half[1], 0.0] for sx in (-1, 1) for sy in (-1, 1)])
    local = (corners - centre) @ turn.T
    if local[:, 2].min() <= 1.0:
        return None
    places = (local / local[:, 2:] @ camera.matrix.T)[:, :2]
    left, top = (max(int(v), 0) for v in np.floor(places.min(axis=0)) - 1)
    right, bottom = (min(int(v), most) for v, most in zip(
        np.ceil(places.max(axis=0)) + 2, (camera.width, camera.height), strict=True))  # fmt: skip
    return (left, top, right, bottom) if left < right and top < bottom else None


def _coverage(scene: Scene, centre: Array, turn: Array, box: Crop) -> Array:
    """Share of each pixel's area that the board covers; 16 x 16 sight lines where the board's edge runs through one."""
    at_corners = _meets_board(
        scene, centre, turn, np.arange(box[0], box[2] + 1) - 0.5, np.arange(box[1], box[3] + 1)[:, None] - 0.5
    )
    corners = np.stack([at_corners[i : i - 1 or None, j : j - 1 or None] for i in (0, 1) for j in (0, 1)])
    share = corners.all(axis=0).astype(float)
    rows, columns = np.nonzero(corners.any(axis=0) & (share < 1))
    within = (np.arange(16) + 0.5) / 16 - 0.5
    u, v = np.add.outer(columns + box[0], within)[:, None, :], np.add.outer(rows + box[1], within)[:, :, None]
    share[rows, columns] = _meets_board(scene, centre, turn, u, v).mean(axis=(1, 2))
    return share


def _meets_board(scene: Scene, centre: Array, turn: Array, u: NDArray[Any], v: NDArray[Any]) -> NDArray[np.bool_]:
    """Whether the sight lines through those places of the picture, px, meet the board."""
    camera = scene.camera
    u, v = (u - camera.matrix[0, 2]) / camera.focal_px, (v - camera.matrix[1, 2]) / camera.focal_px
    way = [turn[0, k] * u + turn[1, k] * v + turn[2, k] for k in range(3)]
    met = way[2] > 1e-9
    for k in range(2):
        place = centre[k] - centre[2] * way[k] / np.where(met, way[2], 1.0)
        met &= np.abs(place) <= scene.board_half_mm[k] * scene.build.print_scale
    return met


def _integrator() -> dict[str, Any]:
    """Rays through one refraction to whatever shines there: no lamp is sampled, since the page is its own."""
    return {"type": "direct", "emitter_samples": 0, "bsdf_samples": 1}


def _sensor(mi: Any, scene: Scene, centre: Array, turn: Array, box: Crop, samples: int) -> Any:
    """The pinhole camera, cut to the box.

    Convention: Mitsuba's camera has x left and y up, ours x right and y down: half a turn about the line of sight.
        Its pixel i spans i to i + 1, ours i - 1/2 to i + 1/2; the middle of the picture is the same place in both.
    """
    camera = scene.camera
    to_world = np.eye(4)
    to_world[:3, :3] = turn.T @ np.diag([-1.0, -1.0, 1.0])
    to_world[:3, 3] = centre
    reach_mm = float(np.linalg.norm(centre)) + float(np.linalg.norm(scene.board_half_mm)) + 10.0
    return mi.load_dict({
        "type": "perspective",
        "fov_axis": "x",
        "fov": math.degrees(2 * math.atan(camera.width / 2 / camera.focal_px)),
        "near_clip": 0.5,
        "far_clip": reach_mm,
        "to_world": mi.ScalarTransform4f(to_world),
        "sampler": {"type": "multijitter", "sample_count": samples},
        "film": {
            "type": "hdrfilm", "width": camera.width, "height": camera.height, "rfilter": {"type": "box"},
            "pixel_format": "rgb", "component_format": "float32", "sample_border": False,
            "crop_offset_x": box[0], "crop_offset_y": box[1],
            "crop_width": box[2] - box[0], "crop_height": box[3] - box[1],
        },
    })  # fmt: skip


def _grating_meshes(mi: Any, scene: Scene, grating: Grating, segments: int) -> dict[str, Any]:
    """The page's lines under one grating and the sheet over it."""
    lens, centre = scene.badge.lens, scene.board_centre_mm
    across, along = (0, 1) if grating.axis == "x" else (1, 0)
    rect = tuple(value - centre[k % 2] for k, value in enumerate(grating.rect_mm))
    room = (rect[across], rect[across + 2], rect[along], rect[along + 2])
    # Radiance falls by n squared on leaving the glass, and by what is reflected; straight on, this takes both back.
    n = lens.refractive_index
    lamp = n**2 / (1.0 - ((n - 1.0) / (n + 1.0)) ** 2)
    meshes = {}
    for name, value, strips in zip(
        ("ink", "paper"), (scene.ink, scene.paper), _page_strips(scene, grating), strict=True
    ):
        if len(strips):
            meshes[name] = _lit_strips(mi, scene, grating.axis, strips, lamp, value)
    if lens.kind == "lenticular":
        meshes["lenses"] = _lens_mesh(mi, scene, grating.axis, room, segments)
    else:
        meshes |= _mask_meshes(mi, scene, grating.axis, room)
    meshes["walls"] = _walls(mi, scene, grating.axis, room)
    return meshes


def _page_strips(scene: Scene, grating: Grating) -> tuple[Array, Array]:
    """Dark and light strips (N, 4) of a grating as printed: low, high across the lines, begin, end along; board mm."""
    dark, light = [np.empty((0, 4))], [np.empty((0, 4))]
    for cell in grating.cells:
        for kind, first in ((dark, 0.0), (light, cell.duty)):
            kind.append(_cell_strips(scene, cell, grating.axis, first, cell.duty if kind is dark else 1.0 - cell.duty))
    return np.concatenate(dark), np.concatenate(light)


def _cell_strips(scene: Scene, cell: Cell, axis: str, first: float, width: float) -> Array:
    """Strips of one kind in one cell: from `first` of each pitch, `width` of it wide, cut to the cell."""
    across, along = (0, 1) if axis == "x" else (1, 0)
    centre, rect = scene.board_centre_mm, cell.rect_mm
    lines = np.arange(
        math.floor((rect[across] - cell.edge_mm) / cell.pitch_mm) - 1,
        math.ceil((rect[across + 2] - cell.edge_mm) / cell.pitch_mm) + 1,
    )
    low = cell.edge_mm + (lines + first) * cell.pitch_mm
    cut = np.clip(np.stack([low, low + width * cell.pitch_mm]), rect[across], rect[across + 2])
    cut = cut[:, cut[1] > cut[0]]
    strips = np.empty((cut.shape[1], 4))
    strips[:, :2] = cut.T - centre[across]
    strips[:, 2:] = np.array([rect[along], rect[along + 2]]) - centre[along]
    return strips * scene.build.print_scale


def _lit_strips(mi: Any, scene: Scene, axis: str, strips: Array, lamp: float, value: float) -> Any:
    """Strips of the page that shine with one radiance."""
    across, along = strips[:, list(_ACROSS)], strips[:, [2 + k for k in _ALONG]]
    depth = _page_depth_mm(scene, np.maximum(np.abs(across), np.abs(along)))
    return _mesh(mi, axis, across, along, depth, {"emitter": _lamp(mi, lamp * value, lamp), "bsdf": _black(mi)})


def _page_depth_mm(scene: Scene, largest_coordinate_mm: Array) -> Array:
    """How much deeper than z = 0 the page lies, so that rays land where they would have without Mitsuba's offset.

    Source: Mitsuba moves a refracted ray's origin inwards along the surface's normal by d = `RAY_OFFSET` (1 + largest
        coordinate), 0.006 mm at 68 mm from the badge's middle.  With s = sin of the normal's tilt, even over +-q, the
        ray begins d <cos> deeper; at a tangent t more rays meet the flank that faces them, by 1 - t s / cos, so it
        also begins d t <s^2 / cos> aside.  That is worth n <s^2 / cos> of depth, in which a ray gains t/n sideways.
        Left alone, it turns the phase by 0.005 rad at t = 0.3 and 0.010 at 0.6; this takes back all but 0.001.
    """
    lens = scene.badge.lens
    q = lens.pitch_mm * scene.build.lens_scale / 2 / lens.radius_mm if lens.radius_mm else 0.0
    share = 1.0
    if q > 0:
        bent, flat = math.asin(q) / (2 * q), math.sqrt(1 - q * q) / 2
        share = bent + flat - lens.refractive_index * (bent - flat)
    return share * RAY_OFFSET * (1.0 + largest_coordinate_mm)


def _lens_mesh(mi: Any, scene: Scene, axis: str, room: tuple[float, ...], segments: int) -> Any:
    """The lenticular sheet's front: flat strips along the lenses, shaded with the circle's own normals.

    Convention: s is measured across the lenses from the axis of lenticule 0, in the sheet's own twisted frame.
    """
    scene = _seen_along(scene, axis)
    lens, pitch = scene.badge.lens, scene.badge.lens.pitch_mm * scene.build.lens_scale
    assert lens.radius_mm is not None
    if pitch > 2 * lens.radius_mm:
        raise SpecError(f"lens_scale={scene.build.lens_scale:g} spreads the lenses beyond their diameter; give less")
    cuts = (np.arange(segments + 1) / segments - 0.5) * pitch
    axes, strip = _sheet_strips(scene, room, pitch, (cuts[:-1] + cuts[1:]) / 2)
    corner = cuts[strip[:, None] + np.array(_ACROSS)]
    rise = np.sqrt(lens.radius_mm**2 - corner**2)
    slope, facing = corner / lens.radius_mm, -rise / lens.radius_mm
    twist = scene.build.twist_rad
    normals = np.stack([slope * math.cos(twist), slope * math.sin(twist), facing], axis=-1)
    across, along = _sheet_places(scene, room, axes[:, None] + corner)
    depth = lens.radius_mm - rise - lens.thickness_mm
    return _mesh(mi, axis, across, along, depth, {"bsdf": _glass(mi, lens.refractive_index)}, normals=normals)


def _mask_meshes(mi: Any, scene: Scene, axis: str, room: tuple[float, ...]) -> dict[str, Any]:
    """A line mask: dark strips, and clear ones of a flat slab between them, centred where lenses have their axes."""
    scene = _seen_along(scene, axis)
    lens, pitch = scene.badge.lens, scene.badge.lens.pitch_mm * scene.build.lens_scale
    assert lens.open_fraction is not None
    meshes: dict[str, Any] = {}
    for name, middle, width in (("bars", 0.5, 1.0 - lens.open_fraction), ("openings", 0.0, lens.open_fraction)):
        if width <= 0:
            continue
        places, _ = _sheet_strips(scene, room, pitch, np.array([middle * pitch]))
        half = width * pitch / 2
        corner = places[:, None] + middle * pitch + np.where(np.array(_ACROSS) > 0, half, -half)
        across, along = _sheet_places(scene, room, corner)
        parts = {"emitter": _lamp(mi, scene.ink, 1.0), "bsdf": _black(mi)} if name == "bars" else {
            "bsdf": _glass(mi, lens.refractive_index)}  # fmt: skip
        meshes[name] = _mesh(mi, axis, across, along, np.full(across.shape, -lens.thickness_mm), parts)
    return meshes


def _seen_along(scene: Scene, axis: str) -> Scene:
    """The scene with its twist told from across to along: on a grating of the other axis these change places."""
    if axis == "x":
        return scene
    return replace(scene, build=replace(scene.build, twist_rad=-scene.build.twist_rad))


def _walls(mi: Any, scene: Scene, axis: str, room: tuple[float, ...]) -> Any:
    """The sheet's four sides, white from outside: a sight line beside the sheet sees paper, as in `analytic`.

    Convention: their feet stand out as far as lines printed too large reach beyond the sheet.
    """
    overhang = max(scene.build.print_scale - 1.0, 0.0) * max(abs(edge) for edge in room)
    tops, feet = (
        [(room[k] + (-out, out)[k % 2], room[m] + (-out, out)[m % 2]) for k, m in ((0, 2), (0, 3), (1, 3), (1, 2))]
        for out in (0.0, overhang)
    )
    # Going down at one corner and up at the next turns each side's face outwards.
    corners = np.array([[tops[k], feet[k], feet[(k + 1) % 4], tops[(k + 1) % 4]] for k in range(4)])
    depth = np.broadcast_to(
        np.array([-scene.badge.lens.thickness_mm, 0.0, 0.0, -scene.badge.lens.thickness_mm]), (4, 4)
    )
    parts = {"emitter": _lamp(mi, scene.paper, 1.0), "bsdf": _black(mi)}
    return _mesh(mi, axis, corners[..., 0], corners[..., 1], depth, parts)


def _sheet_strips(
    scene: Scene, room: tuple[float, ...], pitch: float, middles: Array
) -> tuple[Array, NDArray[np.intp]]:
    """Which strips of the sheet lie in its rectangle, by their middles: axis of each one's lens, and its number there.

    Convention: room is low, high across, begin, end along, board mm; middles are relative to a lens's axis.
    """
    shift = math.sin(scene.build.twist_rad) * (room[2] + room[3]) / 2 - scene.build.lens_offset_mm
    reach = [math.cos(scene.build.twist_rad) * edge + shift for edge in room[:2]]
    axes = np.arange(math.floor(reach[0] / pitch) - 1, math.ceil(reach[1] / pitch) + 2) * pitch
    place = np.add.outer(axes, middles)
    lens, strip = np.nonzero((place >= reach[0]) & (place <= reach[1]))
    return np.asarray(axes[lens], float), np.asarray(strip, np.intp)


def _sheet_places(scene: Scene, room: tuple[float, ...], s: Array) -> tuple[Array, Array]:
    """Board coordinates across and along, (N, 4), of strips' corners; their ends lie on the rectangle's."""
    along = np.broadcast_to(np.array(room)[[2 + k for k in _ALONG]], s.shape)
    twist = scene.build.twist_rad
    return (s + scene.build.lens_offset_mm - along * math.sin(twist)) / math.cos(twist), along


def _rest_of_page(mi: Any, scene: Scene) -> Any:
    """Paper and markers, and paper beside the printed lines, just behind the lines' own strips."""
    picture = page_texture(scene)
    half, scale = np.array(scene.board_half_mm), scene.build.print_scale
    across, along = (np.array([[-side, side]])[:, list(turn)] for side, turn in ((half[0], _ACROSS), (half[1], _ALONG)))
    # The picture's last row and column may reach beyond the board by a part of a pixel.
    share = 2 * half * TEXTURE_PX_PER_MM / np.array(picture.shape[::-1])
    places = np.stack([np.array(_ACROSS) * share[0], np.array(_ALONG) * share[1]], axis=-1)
    bitmap = mi.Bitmap(np.stack([picture, np.ones_like(picture), np.ones_like(picture)], axis=-1))
    lamp = mi.load_dict({
        "type": "area",
        "radiance": {"type": "bitmap", "bitmap": bitmap, "raw": True, "filter_type": "nearest", "wrap_mode": "clamp"},
    })  # fmt: skip
    behind = np.full(across.shape, BEHIND_MM)
    parts = {"emitter": lamp, "bsdf": _black(mi)}
    return _mesh(mi, "x", across * scale, along * scale, behind, parts, places=places)


def _lamp(mi: Any, value: float, through: float) -> Any:
    """An even lamp: its radiance in red, and in the others what tells that it was seen."""
    return mi.load_dict({"type": "area", "radiance": {"type": "rgb", "value": [value, through, through]}})


def _black(mi: Any) -> Any:
    """A surface that reflects nothing: the page is only seen by its own light."""
    return mi.load_dict({"type": "diffuse", "reflectance": 0.0})


def _glass(mi: Any, refractive_index: float) -> Any:
    """A clear surface between air in front and the sheet behind."""
    return mi.load_dict({"type": "dielectric", "int_ior": refractive_index, "ext_ior": 1.0})


def _mesh(
    mi: Any, axis: str, across: Array, along: Array, depth: Array, parts: dict[str, Any], *,
    normals: Array | None = None, places: Array | None = None,
) -> Any:  # fmt: skip
    """A Mitsuba mesh of strips.

    Parameters: across, along, depth: (N, 4), corners in the order of `_ACROSS` and `_ALONG`, board mm; parts: emitter
        and bsdf; normals: (N, 4, 3) in the same axes; places: (N, 4, 2) in the texture, v down.
    Convention: faces look at the camera, to -z, whichever way the lenses run.
    """
    order, faces = [0, 1, 2], np.array([0, 1, 2, 0, 2, 3])
    if axis == "y":
        # Swapping x and y is a mirror, which turns faces over.
        order, faces = [1, 0, 2], faces[[0, 2, 1, 3, 5, 4]]
    props = mi.Properties()
    for name, part in parts.items():
        props[name] = part
    mesh = mi.Mesh("strips", across.size, 2 * len(across), props=props, has_vertex_normals=normals is not None,
                   has_vertex_texcoords=places is not None)  # fmt: skip
    figures = mi.traverse(mesh)
    points = np.stack([across, along, depth], axis=-1)[..., order]
    figures["vertex_positions"] = points.astype(np.float32).ravel()
    figures["faces"] = (4 * np.arange(len(across))[:, None] + faces).astype(np.uint32).ravel()
    if places is not None:
        figures["vertex_texcoords"] = places.astype(np.float32).ravel()
    figures.update()
    if normals is not None:
        # Only now: changing the points makes Mitsuba compute normals of its own.
        figures["vertex_normals"] = normals[..., order].astype(np.float32).ravel()
        figures.update()
    return mesh
