"""How visibility changes the weights of particles (PBPF-V)."""

from dataclasses import replace

from filter_fixtures import PERIOD, write_blocks_scene
import numpy as np
import pytest
from update_fixtures import NOMINAL, FreeMotion, make_config, see

from pbpf_drake.config.distributions import PoseStddev
from pbpf_drake.config.visibility_config import VisibilityConfig
from pbpf_drake.filtering.filter_state import FilterState, MakeInitialState
from pbpf_drake.filtering.particle_filter_update import ParticleFilterUpdate
from pbpf_drake.motion.control_path import ControlPath
from pbpf_drake.visibility.visibility_model import VisibilityModel
from pbpf_drake.visibility.visibility_weights import visibility_log_factor

# A roof between the camera and the table. Seen from there, it hides the table
# around x = 0.6.
ROOF = """
- add_model: {name: roof, file: package://scene/roof.sdf}
- add_weld:
    parent: world
    child: roof::roof
    X_PC: {translation: [0.5, 0.0, 0.5]}
"""
ROOF_SDF = """<?xml version="1.0"?>
<sdf version="1.7"><model name="roof"><link name="roof">
  <collision name="roof">
    <geometry><box><size>0.2 0.4 0.01</size></box></geometry>
  </collision>
</link></model></sdf>
"""
SHOWN, HIDDEN = [0.1, 0.2, 0.0065], [0.63, 0.0, 0.0065]


@pytest.fixture(scope="module")
def roofed(tmp_path_factory):
    """The visibility of two blocks, which a roof may hide."""
    folder = tmp_path_factory.mktemp("roofed")
    (folder / "roof.sdf").write_text(ROOF_SDF)
    scene = write_blocks_scene(folder, {"one": SHOWN, "two": HIDDEN}, more=ROOF)
    return VisibilityModel(scene=scene, num_rays=30)


THRESHOLDS = (
    VisibilityConfig(high_weight=0.7, low_weight=0.2, penalty=0.4),
    VisibilityConfig(high_weight=0.9, low_weight=0.6, penalty=0.1),
)


def _seeing_update(visibility, velocity) -> ParticleFilterUpdate:
    return ParticleFilterUpdate(
        config=make_config(num_particles=4, process_noise=PoseStddev()),
        motion_model=FreeMotion(velocity),
        visibility_model=visibility,
        visibility_configs=THRESHOLDS,
    )


def _state_of_two() -> FilterState:
    """All four combinations of what is hidden of two objects."""
    state = MakeInitialState(4, np.tile(NOMINAL, (2, 1)))
    state.num_estimates[:] = 2
    state.poses[:, 0, 4:] = [SHOWN, SHOWN, HIDDEN, HIDDEN]
    state.poses[:, 1, 4:] = [SHOWN, HIDDEN, SHOWN, HIDDEN]
    # Apart, so that they don't hide each other.
    state.poses[:, 1, 5] -= 0.1
    return state


def _see(visibility, state, seen=None, velocity=(0, 0, 0)) -> FilterState:
    """The robot's probe is far from everything."""
    end = PERIOD * (state.step[0] + 1)
    update = _seeing_update(visibility, velocity)
    path = ControlPath(np.array([end - PERIOD, end]), np.array([[0, -0.6]] * 2))
    return update.Update(
        state, path=path, detections=seen or {}, scratch=update.MakeScratch()
    )


def test_hidden_particles_are_preferred_where_nothing_is_detected(roofed):
    state = _see(roofed, _state_of_two())
    one, two = THRESHOLDS
    factors = np.outer(
        [one.low_weight, one.high_weight], [two.low_weight, two.high_weight]
    )
    np.testing.assert_allclose(
        state.weights, factors.ravel() / np.sum(factors), rtol=1e-12
    )


def test_hidden_particles_are_penalised_where_something_is_detected(roofed):
    before = _state_of_two()
    # Equally far from all particles, so that only visibility counts.
    middle = (np.array(SHOWN) + HIDDEN) / 2
    state = _see(roofed, before, {0: [see(before, middle)]})
    one, two = THRESHOLDS
    factors = np.outer([1, one.penalty], [two.low_weight, two.high_weight])
    np.testing.assert_allclose(
        state.weights, factors.ravel() / np.sum(factors), rtol=1e-9
    )


def test_visibility_of_what_is_not_tracked_yet_does_not_count(roofed):
    before = _state_of_two()
    before = replace(before, num_estimates=np.array([2.0, 0.0]))
    weights = _see(roofed, before).weights
    one = THRESHOLDS[0]
    factors = np.array([one.low_weight] * 2 + [one.high_weight] * 2)
    np.testing.assert_allclose(weights, factors / np.sum(factors), rtol=1e-12)


def test_visibility_does_not_count_where_a_track_begins(roofed):
    """The detection says more than the first particles' positions."""
    before = _state_of_two()
    before = replace(before, num_estimates=np.array([2.0, 0.0]))
    # At the edge of the roof's shadow, some would be hidden.
    state = _see(roofed, before, {1: [see(before, [0.43, 0.1, 0.0065])]})
    one = THRESHOLDS[0]
    factors = np.array([one.low_weight] * 2 + [one.high_weight] * 2)
    np.testing.assert_allclose(
        state.weights, factors / np.sum(factors), rtol=1e-12
    )
    assert np.ptp(state.poses[:, 1, 4]) > 0.005


@pytest.mark.parametrize(
    "fraction, x, factor", [(0.0, 0.2, 1.0), (1.0, 0.4, THRESHOLDS[0].penalty)]
)
def test_visibility_counts_as_it_was_when_the_image_was_taken(
    roofed, fraction, x, factor
):
    """Two particles go under the roof while two others stay in sight."""
    before = _state_of_two()
    before = replace(before, num_estimates=np.array([2.0, 0.0]))
    before.poses[:, 0, 4] = [0.35, 0.35, 0.05, 0.05]
    # Equally far from all of them at that time.
    seen = see(before, [x, 0.1, 0.0065], fraction)
    before.poses[:, 0, 5:] = [0.1, 0.0065]
    state = _see(roofed, before, {0: [seen]}, velocity=[0.2 / PERIOD, 0, 0])
    expected = np.array([factor, factor, 1, 1]) / (2 * factor + 2)
    np.testing.assert_allclose(state.weights, expected, rtol=1e-9)


def test_without_a_detection_hidden_particles_get_the_high_weight():
    config = VisibilityConfig(
        high_weight=0.75, low_weight=0.25, high_visibility=0.95
    )
    factor = visibility_log_factor(
        np.array([0, 0.94, 0.95, 1]), detected=False, config=config
    )
    np.testing.assert_allclose(np.exp(factor), [0.75, 0.75, 0.25, 0.25])


def test_with_a_detection_hidden_particles_are_penalised():
    config = VisibilityConfig(low_visibility=0.5, penalty=0.33)
    factor = visibility_log_factor(
        np.array([0, 0.49, 0.5, 1]), detected=True, config=config
    )
    np.testing.assert_allclose(np.exp(factor), [0.33, 0.33, 1, 1])
