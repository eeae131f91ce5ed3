"""Colors tell what is drawn, in Meshcat as in images."""

import colorsys

import pytest

from pbpf_drake.views.palette import (
    DETECTION_BGR,
    DETECTION_RGBA,
    ESTIMATE_BGR,
    ESTIMATE_RGBA,
    TRUTH_RGBA,
)


def _hue_of_rgba(color) -> float:
    return colorsys.rgb_to_hsv(color.r(), color.g(), color.b())[0]


def _hue_of_bgr(color) -> float:
    blue, green, red = (x / 255 for x in color)
    return colorsys.rgb_to_hsv(red, green, blue)[0]


@pytest.mark.parametrize(
    "rgba, bgr",
    [(ESTIMATE_RGBA, ESTIMATE_BGR), (DETECTION_RGBA, DETECTION_BGR)],
)
def test_both_shades_of_a_thing_have_about_the_same_hue(rgba, bgr):
    assert _hue_of_rgba(rgba) == pytest.approx(_hue_of_bgr(bgr), abs=0.03)


def test_hues_of_different_things_are_far_apart():
    hues = sorted(
        map(_hue_of_rgba, (ESTIMATE_RGBA, DETECTION_RGBA, TRUTH_RGBA))
    )
    assert min(b - a for a, b in zip(hues, hues[1:], strict=False)) > 0.2
