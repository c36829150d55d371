"""A real RTSP server and a real screen.  Each test names the wrong implementation it catches."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator

import pytest

from kit.places import TESTS
from kit.programs import needs
from kit.streams import FPS, pictures, watched, write_stream
from moireid.errors import MediaError
from moireid.sandbox.seal import MEANS

#: Debian's, which has the packages of GStreamer.
PYTHON = "/usr/bin/python3"
ASK = "import gi; gi.require_version('GstRtspServer', '1.0'); from gi.repository import GstRtspServer"


@pytest.fixture(scope="module")
def camera(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """The address of a network camera that shows a genuine board for four seconds, to and fro."""
    if subprocess.run([PYTHON, "-c", ASK], capture_output=True, check=False).returncode:
        pytest.skip("GStreamer's RTSP server is not installed (Debian: gir1.2-gst-rtsp-server-1.0 python3-gi)")
    film = write_stream(tmp_path_factory.mktemp("camera") / "film.mkv", pictures(), kind="matroska")
    command = [PYTHON, str(TESTS / "kit" / "rtsp_server.py"), str(film)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as server:
        assert server.stdout is not None
        yield f"rtsp://me:secret@127.0.0.1:{int(server.stdout.readline())}/badge"
        server.kill()


@pytest.mark.slow
@pytest.mark.alone
def test_a_network_camera_is_judged_by_its_own_clock(camera: str) -> None:
    """Catches: a process without the network that such a stream needs; a password in a report; times of arrival."""
    found = watched(camera)
    assert found["verdict"] == "accept" and found["sealed"] == list(MEANS)
    assert "secret" not in str(found) and abs(found["input"]["fps"] - FPS) < 0.5
    # Of four seconds; the clock settles for the first of them.
    assert found["frames"]["tracked"] >= 60


@pytest.mark.slow
@pytest.mark.alone
def test_a_camera_that_is_not_there_is_a_sentence(camera: str) -> None:
    """Catches: an error of a library in the place of a sentence, or one that shows the password."""
    for address in (camera.replace("/badge", "/none"), "rtsp://me:secret@127.0.0.1:9/badge"):
        with pytest.raises(MediaError, match="cannot be read") as refused:
            watched(address)
        assert "secret" not in str(refused.value)


@pytest.mark.slow
@pytest.mark.alone
@pytest.mark.skipif(sys.platform != "linux", reason="X11 is asked of Linux alone")
def test_a_screen_is_read_as_it_is_shown(monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: a screen that gives no pictures, or their times by another clock, so that all of them come too late."""
    with subprocess.Popen(
        [needs("Xvfb"), "-displayfd", "1", "-screen", "0", "640x360x24"], stdout=subprocess.PIPE, text=True
    ) as server:
        assert server.stdout is not None
        monkeypatch.setenv("DISPLAY", f":{int(server.stdout.readline())}")
        monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
        found = watched("screen", seconds=3.0)
        with pytest.raises(MediaError, match="window 0x999 cannot be read"):
            watched("screen:0x999", seconds=3.0)
        server.kill()
    assert found["verdict"] == "inconclusive" and found["frames"]["read"] > 30
    assert (found["input"]["width"], found["input"]["height"]) == (640, 360)
    assert {one["code"]: one["level"] for one in found["reasons"]}["clock"] == "pass"
