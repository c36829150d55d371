"""What people wear in these tests."""

from __future__ import annotations

import pytest
from PIL import Image

from moireid.artwork.content import Artwork


@pytest.fixture(scope="module")
def content(tmp_path_factory: pytest.TempPathFactory) -> Artwork:
    """A wide logo and a portrait."""
    folder = tmp_path_factory.mktemp("pictures")
    Image.new("RGB", (300, 100), "teal").save(folder / "logo.png")
    Image.new("RGB", (80, 100), "gray").save(folder / "face.png")
    return Artwork(folder / "logo.png", folder / "face.png", (0.1, 0.3, 0.5))
