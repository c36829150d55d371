"""One ray through a cylinder lens, by Snell's law.

Convention: s runs across the lenses, t along them, both in mm; z runs into the sheet from the plane of its crowns, so
the flat back is at z = thickness.  A ray is given by where it crosses z = 0 and by ds/dz and dt/dz in air.
Source: intersection of a line with a circle, Snell's law as vectors, Fresnel's equations.  No phase law and
no small angle enters.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

#: A ray that grazes may pass over this many lenses before it meets one.
MOST_LENSES = 12
STEPS = 3


@njit(cache=True, fastmath=True, error_model="numpy")
def through_cylinder(s, ds, dt, edge, pitch, radius, thickness, index, air=0.0, conic=0.0):
    """Where the ray lands on the back: s, t less where it began, and the share of light that passes the surface.

    edge: s of an edge between two lenses; radius: at the crown; air: mm of it between the sheet's back and the print;
    conic: constant of the profile, x^2 + (1 + conic) z^2 = 2 radius z.
    """
    cell = math.floor((s - edge) / pitch)
    middle, z, x = 0.0, 0.0, 0.0
    for _ in range(MOST_LENSES):
        middle = edge + (cell + 0.5) * pitch
        x = s - middle
        b = ds * x - radius
        disc = b * b - (1.0 + conic + ds * ds) * x * x
        if disc >= 0.0:
            z = x * x / (math.sqrt(disc) - b)
            x += ds * z
            if abs(x) <= 0.5 * pitch:
                break
        cell += 1 if ds > 0 else -1
    deep = (1.0 + conic) * z - radius
    length = radius if conic == 0.0 else math.sqrt(x * x + deep * deep)
    return _refract(s, 0.0, ds, dt, z, x / length, 0.0, deep / length, thickness, index, air)


@njit(cache=True, fastmath=True, error_model="numpy")
def through_cylinders(count, s, t, ds, dt, share, edge, pitch, radius, thickness, index, air=0.0, conic=0.0):
    """As `through_cylinder` for `count` rays: s and t become where they land, share what passes.

    The loop has no branch, so that a processor does several rays at a time; a ray passes over `STEPS` lenses at
    most, which is enough up to slopes of one.  Without `conic` numba compiles it for circles.
    """
    for k in range(count):
        cell = np.floor((s[k] - edge) / pitch)
        way = 1.0 if ds[k] > 0 else -1.0
        a = 1.0 + conic + ds[k] * ds[k]
        z, x = 0.0, 0.0
        for step in range(STEPS):
            x = s[k] - edge - (cell + 0.5) * pitch
            b = ds[k] * x - radius
            disc = b * b - a * x * x
            z = x * x / (math.sqrt(max(disc, 0.0)) - b)
            x += ds[k] * z
            missed = disc < 0.0 or abs(x) > 0.5 * pitch
            cell += way if missed and step < STEPS - 1 else 0.0
        deep = (1.0 + conic) * z - radius
        length = radius if conic == 0.0 else math.sqrt(x * x + deep * deep)
        s[k], t[k], share[k] = _refract(
            s[k], t[k], ds[k], dt[k], z, x / length, 0.0, deep / length, thickness, index, air
        )


@njit(cache=True, fastmath=True, error_model="numpy", inline="always")
def _refract(s, t, ds, dt, z, ns, nt, nz, thickness, index, air):
    """Turn the ray at the surface, whose outward normal is (ns, nt, nz), and follow it to the flat back."""
    length = 1.0 / math.sqrt(1.0 + ds * ds + dt * dt)
    es, et, ez = ds * length, dt * length, length
    cos_in = -(es * ns + et * nt + ez * nz)
    ratio = 1.0 / index
    cos_out = math.sqrt(1.0 - ratio * ratio * (1.0 - cos_in * cos_in))
    turn = ratio * cos_in - cos_out
    fs, ft, fz = ratio * es + turn * ns, ratio * et + turn * nt, ratio * ez + turn * nz
    deep = (thickness - z) / fz
    across = (cos_in - index * cos_out) / (cos_in + index * cos_out)
    along = (index * cos_in - cos_out) / (index * cos_in + cos_out)
    # Air beneath the sheet turns the ray back to the slope that it had outside of a flat sheet, or mirrors it at the
    # back, where it shows the room.
    leaving = 1.0 - index * index * (fs * fs + ft * ft)
    beyond = air * index / math.sqrt(max(leaving, 1e-6)) if air > 0 else 0.0
    share = 1.0 - 0.5 * (across * across + along * along) if air == 0 or leaving > 0 else 0.0
    return s + ds * z + fs * (deep + beyond), t + dt * z + ft * (deep + beyond), share
