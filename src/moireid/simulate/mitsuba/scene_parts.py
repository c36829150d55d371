"""Meshes, surfaces, lamps and camera as Mitsuba's own objects; `mi` is its module with a variant set.

Convention: board frame of `motion`, mm, origin at the board's centre: Mitsuba starts a refracted ray 9e-5 (1 + largest
coordinate) away from the surface, which is least in this frame.  The red channel carries radiance; the caller decides
what green and blue carry.
Source: Mitsuba 3.9.1, plugins `dielectric`, `area`, `perspective`, `bitmap`.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from moireid.frames import OwnFrame, own_frame
from moireid.simulate.analytic.analytic_renderer import Crop
from moireid.simulate.analytic.traced_page import TEXTURE_PX_PER_MM, page_texture
from moireid.simulate.mitsuba.sheet import ACROSS, ALONG, BEHIND_MM, Strips
from moireid.simulate.motion import Poses
from moireid.simulate.scene import Scene

Array = NDArray[np.float64]


def shining(mi: Any, red: float, green: float) -> dict[str, Any]:
    """A surface that emits these radiances and reflects nothing."""
    lamp = mi.load_dict({"type": "area", "radiance": {"type": "rgb", "value": [red, green, 0.0]}})
    return {"emitter": lamp, "bsdf": _black(mi)}


def clear(mi: Any, refractive_index: float) -> dict[str, Any]:
    """A clear surface between air in front and the sheet behind."""
    return {"bsdf": mi.load_dict({"type": "dielectric", "int_ior": refractive_index, "ext_ior": 1.0})}


def _black(mi: Any) -> Any:
    """A surface that reflects nothing."""
    return mi.load_dict({"type": "diffuse", "reflectance": 0.0})


def rest_of_page(mi: Any, scene: Scene) -> Any:
    """Paper and markers, and paper around the printed lines, just behind the lines' own strips.

    Convention: the picture is `analytic.page_texture`, one cell of it one colour.
    """
    picture = page_texture(scene)
    half, scale = np.array(scene.board_half_mm), scene.build.print_scales
    across, along = (np.array([[-side, side]])[:, list(turn)] for side, turn in ((half[0], ACROSS), (half[1], ALONG)))
    # The picture's last row and column may reach beyond the board by a part of a pixel.
    share = 2 * half * TEXTURE_PX_PER_MM / np.array(picture.shape[::-1])
    places = np.stack([np.array(ACROSS) * share[0], np.array(ALONG) * share[1]], axis=-1)
    bitmap = mi.Bitmap(np.stack([picture, np.ones_like(picture), np.zeros_like(picture)], axis=-1))
    lamp = mi.load_dict(
        {
            "type": "area",
            "radiance": {
                "type": "bitmap",
                "bitmap": bitmap,
                "raw": True,
                "filter_type": "nearest",
                "wrap_mode": "clamp",
            },
        }
    )
    strips = Strips(across * scale[0], along * scale[1], np.full(across.shape, BEHIND_MM))
    return mesh(mi, own_frame("x", scene.badge.page_mm), strips, {"emitter": lamp, "bsdf": _black(mi)}, places=places)


def mesh(mi: Any, frame: OwnFrame, strips: Strips, parts: dict[str, Any], *, places: Array | None = None) -> Any:
    """A Mitsuba mesh of strips.

    Parameters: frame: of the grating; parts: emitter and bsdf; places: (N, 4, 2) in the texture, v down.
    Convention: faces look at the camera, to -z, whichever way the lenses run.
    """
    faces = np.array([0, 1, 2, 0, 2, 3])
    if frame.handed < 0:
        # A reflection turns faces over.
        faces = faces[[0, 2, 1, 3, 5, 4]]
    props = mi.Properties()
    for name, part in parts.items():
        props[name] = part
    count = len(strips.across)
    made = mi.Mesh(
        "strips",
        4 * count,
        2 * count,
        props=props,
        has_vertex_normals=strips.normals is not None,
        has_vertex_texcoords=places is not None,
    )
    figures = mi.traverse(made)
    points = np.concatenate(
        [frame.vectors(np.stack([strips.across, strips.along], axis=-1)), strips.depth[..., None]], axis=-1
    )
    figures["vertex_positions"] = points.astype(np.float32).ravel()
    figures["faces"] = (4 * np.arange(count)[:, None] + faces).astype(np.uint32).ravel()
    if places is not None:
        figures["vertex_texcoords"] = places.astype(np.float32).ravel()
    figures.update()
    if strips.normals is not None:
        normals = np.concatenate([frame.vectors(strips.normals[..., :2]), strips.normals[..., 2:]], axis=-1)
        # Set last, because Mitsuba computes its own normals whenever the points change.
        figures["vertex_normals"] = normals.astype(np.float32).ravel()
        figures.update()
    return made


def pinhole(mi: Any, scene: Scene, view: Poses, box: Crop, size: tuple[int, int], samples: int) -> Any:
    """The camera, its film `size` px wide and high with the box's corner in its own.

    Convention: Mitsuba's camera has x left and y up, ours x right and y down: half a turn about the line of sight.
        Its pixel i spans i to i + 1, ours i - 1/2 to i + 1/2.  The principal point moves, as a share of the film, so
        that a film of one size serves every frame.
    Source: plugin `perspective`; by trial, its offsets count from the principal point to the film's middle.  A wrong
        sign moves the picture by twice the board's distance from the film's middle.
    """
    camera = scene.camera
    to_world = np.eye(4)
    to_world[:3, :3] = view.rotation[0].T @ np.diag([-1.0, -1.0, 1.0])
    to_world[:3, 3] = view.camera_mm[0]
    reach_mm = float(np.linalg.norm(view.camera_mm[0])) + float(np.linalg.norm(scene.board_half_mm)) + 10.0
    middle = box[0] - 0.5 + size[0] / 2, box[1] - 0.5 + size[1] / 2
    return mi.load_dict(
        {
            "type": "perspective",
            "fov_axis": "x",
            "fov": math.degrees(2 * math.atan(size[0] / 2 / camera.focal_px)),
            "principal_point_offset_x": (middle[0] - camera.matrix[0, 2]) / size[0],
            "principal_point_offset_y": (middle[1] - camera.matrix[1, 2]) / size[1],
            "near_clip": 0.5,
            "far_clip": reach_mm,
            "to_world": mi.ScalarTransform4f(to_world),
            "sampler": {"type": "multijitter", "sample_count": samples},
            "film": {
                "type": "hdrfilm",
                "width": size[0],
                "height": size[1],
                "rfilter": {"type": "box"},
                "pixel_format": "rgb",
                "component_format": "float32",
                "sample_border": False,
            },
        }
    )
