"""The replay in a browser without a screen; skipped where there is none."""

from pathlib import Path
import shutil
import subprocess

import cv2
from filter_fixtures import PERIOD, make_push_log, planar_scene
import numpy as np
from pydrake.geometry import Meshcat
import pytest

from pbpf_drake.config.particle_filter_config import ParticleFilterConfig
from pbpf_drake.tracking.tracking_diagram import Track
from pbpf_drake.views.scene_meshcat import SaveReplay

_BROWSERS = (
    "chromium",
    "chromium-browser",
    "google-chrome",
    "google-chrome-stable",
)
_OPTIONS = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    # WebGL without a graphics card.
    "--enable-unsafe-swiftshader",
    "--hide-scrollbars",
    "--window-size=640,480",
    # What the page prints, with the errors of its scripts.
    "--enable-logging=stderr",
)
# The legend is in this corner: rows from here, columns up to there.
_LEGEND = (380, 320)


def _find_browser() -> str:
    for name in _BROWSERS:
        path = shutil.which(name)
        if path:
            return path
    pytest.skip(f"there is no browser here; looked for {list(_BROWSERS)}")


def _screenshot(browser: str, page: Path, *, after_ms: int) -> np.ndarray:
    """Returns what a page looks like after some time of its own."""
    picture = page.with_name(f"{after_ms}.png")
    run = subprocess.run(
        [
            browser,
            *_OPTIONS,
            f"--user-data-dir={page.parent / f'profile_{after_ms}'}",
            f"--virtual-time-budget={after_ms}",
            f"--screenshot={picture}",
            page.as_uri(),
        ],
        capture_output=True,
        text=True,
        timeout=120,
        check=True,
    )
    assert "Uncaught" not in run.stderr, run.stderr
    return cv2.imread(str(picture))


@pytest.fixture(scope="module")
def pictures(tmp_path_factory) -> list[np.ndarray]:
    """The replay of a push, at its beginning and later."""
    browser = _find_browser()
    folder = tmp_path_factory.mktemp("replay")
    meshcat = Meshcat()
    # Its own lines have colors as well.
    for path in ("/Axes", "/Grid"):
        meshcat.SetProperty(path, "visible", False)
    meshcat.StartRecording(set_visualizations_while_recording=False)
    Track(
        scene=planar_scene(),
        log=make_push_log(duration=4.0, blackout=(0.3, 1.0)),
        method="pbpf",
        config=ParticleFilterConfig(num_particles=5, period=PERIOD),
        meshcat=meshcat,
    )
    SaveReplay(meshcat, folder / "replay.html")
    meshcat.Delete()
    return [
        _screenshot(browser, folder / "replay.html", after_ms=time)
        for time in (600, 3500)
    ]


def _without_legend(picture: np.ndarray) -> np.ndarray:
    picture = picture.astype(int)
    picture[_LEGEND[0] :, : _LEGEND[1]] = 0
    return picture


def _colored(picture: np.ndarray) -> dict[str, np.ndarray]:
    """Tells of every pixel if it has one of the three colors."""
    blue, green, red = np.moveaxis(_without_legend(picture), -1, 0)
    return {
        "estimate": (green > red + 30) & (green > blue + 30),
        "detection": (red > blue + 60) & (green > blue + 60),
        "truth": (blue > red + 60) & (blue > green + 40),
    }


def test_the_page_has_the_size_of_the_window_and_is_not_blank(pictures):
    for picture in pictures:
        assert picture.shape == (480, 640, 3)
        colors = np.unique(_without_legend(picture).reshape(-1, 3), axis=0)
        assert len(colors) > 500


@pytest.mark.parametrize("kind", ["estimate", "detection", "truth"])
def test_estimate_detection_and_truth_are_seen_in_their_colors(pictures, kind):
    for picture in pictures:
        assert _colored(picture)[kind].sum() > 20


def test_the_legend_is_in_its_corner(pictures):
    for picture in pictures:
        corner = picture[_LEGEND[0] :, : _LEGEND[1]].astype(int)
        # Dark text on a light box, and three squares.
        assert (corner.min(axis=-1) > 200).sum() > 3000
        assert (corner.max(axis=-1) < 90).sum() > 200


def test_the_estimate_moves_on_and_the_last_detection_stays(pictures):
    def center(picture, kind):
        rows, columns = np.nonzero(_colored(picture)[kind])
        return np.array([columns.mean(), rows.mean()])

    moved = {
        kind: np.linalg.norm(
            center(pictures[1], kind) - center(pictures[0], kind)
        )
        for kind in ("estimate", "truth", "detection")
    }
    assert moved["estimate"] > 50 and moved["truth"] > 50, moved
    assert moved["detection"] < 0.5 * moved["truth"], moved
