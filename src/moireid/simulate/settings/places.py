"""Rooms, stage, desk and lectern; and the settings in which a badge can be filmed, by name.

Convention: board frame of `motion`, mm.  What is far is out of focus, as a phone's camera shows it.
"""

from __future__ import annotations

import numpy as np

from moireid.errors import SpecError
from moireid.simulate.scene import Scene
from moireid.simulate.settings.drawn_layers import Canvas, Layer
from moireid.simulate.settings.wearing import board_layer, cord, holder, person

#: Depth of the walls behind the badge, and of the lectern before it, mm.
WALL_MM, LECTERN_MM, DESK_MM = 2400.0, -160.0, 4.0
WALL_RECT = (-4200.0, -2400.0, 4200.0, 2400.0)


def setting_named(name: str, scene: Scene, seed: int) -> list[Layer]:
    """All that is around the badge in a setting.

    Parameters
    ----------
    name : str
        One of `SETTINGS`.
    scene : Scene
        The badge as built, with its print.
    seed : int
        Of the grain of cloth, wood and walls.

    Returns
    -------
    list of Layer
        Flat pictures at their depths; the board's own colours are one of them.

    Raises
    ------
    SpecError
        For a name that is none.
    """
    if name not in SETTINGS:
        raise SpecError(f"scene {name!r} is not known; choose one of {', '.join(SETTINGS)}")
    half = scene.printed_half_mm
    badge = [holder(half)] if scene.print_picture is None else [holder(half), board_layer(scene.print_picture, half)]
    return badge + SETTINGS[name](half, seed)


def _worn(half: tuple[float, float], seed: int) -> list[Layer]:
    return [cord(half), person(seed), office(seed)]


def _lectern(half: tuple[float, float], seed: int) -> list[Layer]:
    return [cord(half), person(seed), stage(seed), lectern(half, seed)]


def _call(half: tuple[float, float], seed: int) -> list[Layer]:
    return [cord(half), person(seed), study(seed)]


def _desk(half: tuple[float, float], seed: int) -> list[Layer]:
    return [desk(half, seed)]


SETTINGS = {"desk": _desk, "worn": _worn, "lectern": _lectern, "call": _call}


def office(seed: int) -> Layer:
    """A light office: a window on the left, a plant, a picture, and a door on the right."""
    wall = _wall("#cfc8bb", seed)
    wall.rect((-3000, -1500, -900, 500), "#f4f4f0", 10)
    for x in (-2930, -1920):
        wall.rect((x, -1430, x + 940, 430), "#bfdcf2")
        wall.polygon([(x, 430), (x, 60), (x + 320, -60), (x + 620, 80), (x + 940, -20), (x + 940, 430)], "#8fae8a")
    wall.rect((-3050, 500, -850, 560), "#e9e6df")
    wall.rect((500, -1150, 1250, -350), "#5b4636")
    wall.rect((540, -1110, 1210, -390), "#e8e1d2")
    wall.curve([(600, -480), (760, -900), (900, -620), (1020, -980), (1160, -480)], "#44748f")
    wall.rect((2100, -1250, 3100, 2400), "#8a6d52")
    wall.rect((2190, -1150, 3010, 2400), "#a0805f")
    wall.ellipse((2280, 500), (45, 45), "#d6c48e")
    _plant(wall, (1650.0, 1200.0))
    return _far(wall, 9.0)


def study(seed: int) -> Layer:
    """A study at home: shelves with books, a lamp that is on, a plant."""
    wall = _wall("#b9c3c4", seed)
    rng = np.random.default_rng([seed, 77])
    wall.rect((-3400, -1900, -500, 1900), "#6d4f37")
    for shelf in range(6):
        top = -1840 + shelf * 620
        wall.rect((-3340, top, -560, top + 560), "#3d2c20")
        x = -3320.0
        while x < -700:
            wide, high = rng.uniform(45, 110), rng.uniform(330, 500)
            colour = ["#8c2f39", "#2f5d8c", "#d9b44a", "#3e7a5e", "#e4ddd0", "#5d4a7a", "#b5651d", "#3b3f46"][
                rng.integers(8)
            ]
            wall.rect((x, top + 560 - high, x + wide, top + 560), colour)
            x += wide + (rng.uniform(100, 420) if rng.random() < 0.1 else 4)
    wall.ellipse((1900, -350), (900, 900), "#ffe9b040", 300)
    wall.polygon([(1700, -520), (2100, -520), (2230, -120), (1570, -120)], "#fff0c4", 8)
    wall.rect((1880, -120, 1920, 1300), "#4b4b4b")
    wall.rect((600, -1300, 1250, -520), "#f0eee8")
    wall.rect((640, -1260, 1210, -560), "#d7e3e6")
    wall.curve([(700, -620), (900, -1150), (1150, -620)], "#7f9aa0")
    _plant(wall, (1000.0, 1500.0))
    return _far(wall, 12.0)


def stage(seed: int) -> Layer:
    """A stage: a curtain in folds, and a bright screen with a slide."""
    wall = Canvas(WALL_RECT, 0.25, "#4a1f2b")
    folds = np.sin(wall.across() * 260 + 3 * np.sin(wall.across() * 37))
    wall.shade(1 + 0.3 * folds + 0.1 * np.sin(wall.across() * 610))
    wall.shade(1.05 - 0.45 * wall.down())
    wall.rect((-3100, -2000, -520, -330), "#10131a")
    wall.rect((-3050, -1950, -570, -380), "#f3f6fa")
    wall.rect((-2880, -1820, -1500, -1700), "#123f6d")
    for k, wide in enumerate((1500, 1250, 1380, 900)):
        wall.rect((-2880, -1530 + 190 * k, -2880 + 0.8 * wide, -1470 + 190 * k), "#8793a3")
    for k, high in enumerate((300, 520, 420, 760, 900)):
        wall.rect((-1560 + 180 * k, -520 - high, -1440 + 180 * k, -520), ("#0f7c7c", "#d98032")[k % 2])
    wall.ellipse((1700, -900), (1300, 1800), "#ffd9a81c", 400)
    return _far(wall, 9.0)


def lectern(half: tuple[float, float], seed: int) -> Layer:
    """A wooden lectern before the badge, whose upper edge is below it, with a microphone at its side."""
    top = half[1] + 105.0
    canvas = Canvas((-420.0, top - 190.0, 420.0, top + 620.0), 1.5)
    canvas.curve(
        [(228, top), (232, top - 90), (196, top - 168), (188, top - 164), (222, top - 86), (216, top)], "#15181c", 0.5
    )
    canvas.ellipse((190.0, top - 172.0), (13.0, 19.0), "#24282d", 0.8)
    canvas.polygon([(-400, top + 10), (-372, top - 16), (372, top - 16), (400, top + 10)], "#b98a5a", 0.6)
    canvas.polygon([(-400, top + 10), (400, top + 10), (400, top + 52), (-400, top + 52)], "#7c5430", 0.6)
    canvas.polygon([(-356, top + 52), (356, top + 52), (338, top + 620), (-338, top + 620)], "#96683c", 0.6)
    canvas.grain(seed + 5, (60.0, 0.9), 0.06)
    canvas.rect((-88, top + 110, 88, top + 286), "#f1ede4", 8)
    canvas.ellipse((0.0, top + 198.0), (62.0, 62.0), "#0f4c81")
    for k in (-1, 0, 1):
        canvas.rect((-34, top + 193 + 24 * k, 34, top + 203 + 24 * k), "#f1ede4", 5)
    return canvas.layer(LECTERN_MM)


def desk(half: tuple[float, float], seed: int) -> Layer:
    """A wooden desk from above, with a notebook, a pen, a cup and the corner of a keyboard."""
    x, y = half[0] + 8, half[1] + 8
    canvas = Canvas((-1300.0, -900.0, 1300.0, 900.0), 1.2, "#a9794c")
    canvas.grain(seed, (90.0, 1.2), 0.05)
    canvas.grain(seed + 1, (400.0, 14.0), 0.06)
    for board in range(-4, 5):
        canvas.rect((-1300, board * 210 + 60, 1300, board * 210 + 62), "#5b3b2090")
    canvas.rect((-x + 4, -y + 8, x + 10, y + 14), "#00000070", 8, 6)
    left = -x - 270
    canvas.rect((left + 8, -150 + 10, left + 218, 170 + 10), "#00000060", 6, 7)
    canvas.rect((left, -150, left + 210, 170), "#1f4e5f", 6)
    canvas.rect((left + 26, -150, left + 34, 170), "#173c49")
    canvas.polygon([(left + 60, 120), (left + 196, -40), (left + 204, -33), (left + 68, 127)], "#d8a227", 0.5)
    canvas.polygon([(left + 60, 120), (left + 52, 136), (left + 68, 127)], "#2a2a2a", 0.5)
    right = x + 170
    canvas.ellipse((right + 10, -90.0), (62, 62), "#00000060", 8)
    canvas.ellipse((right, -100.0), (58, 58), "#eef0f0", 0.6)
    canvas.ellipse((right, -100.0), (38, 38), "#ffffff", 0.6)
    canvas.ellipse((right, -100.0), (34, 34), "#4a2c17", 0.6)
    canvas.rect((x + 60, 150, x + 620, 420), "#c9cdd2", 12)
    for row in range(4):
        for key in range(13):
            canvas.rect((x + 74 + 42 * key, 166 + 58 * row, x + 108 + 42 * key, 212 + 58 * row), "#f4f5f6", 4)
    return canvas.layer(DESK_MM, endless=True)


def _wall(colour: str, seed: int) -> Canvas:
    """A plastered wall, a little brighter on the left."""
    wall = Canvas(WALL_RECT, 0.25, colour)
    wall.grain(seed, (300.0, 300.0), 0.03)
    wall.shade(1.06 - 0.22 * wall.across())
    return wall


def _plant(wall: Canvas, foot: tuple[float, float]) -> None:
    """A plant in a pot."""
    x, y = foot
    wall.polygon([(x - 170, y - 300), (x + 170, y - 300), (x + 130, y), (x - 130, y)], "#b5653f")
    for turn in np.linspace(-1.2, 1.2, 9):
        tip = x + 620 * np.sin(turn), y - 300 - 700 * np.cos(turn)
        side = 70 * np.cos(turn), 70 * np.sin(turn)
        middle = x + 300 * np.sin(turn), y - 300 - 380 * np.cos(turn)
        wall.curve(
            [(x, y - 300), (middle[0] - side[0], middle[1] - side[1]), tip, (middle[0] + side[0], middle[1] + side[1])],
            "#3f7a48",
        )


def _far(wall: Canvas, blur_mm: float) -> Layer:
    """A wall as the finished layer, out of focus."""
    wall.blur(blur_mm)
    return wall.layer(WALL_MM, endless=True)
