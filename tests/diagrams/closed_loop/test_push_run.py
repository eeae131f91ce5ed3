"""One push to its end."""

from closed_loop_fixtures import closed_loop_scene
import numpy as np

from pbpf_drake.diagrams.closed_loop.push_run import RunTask
from pbpf_drake.diagrams.closed_loop.push_task import draw_task


def test_a_run_is_repeatable_and_ends_in_time():
    scene = closed_loop_scene()
    outcomes = [RunTask(scene, "dope", 5, duration=0.5) for _ in range(2)]
    assert outcomes[0].distance == outcomes[1].distance
    np.testing.assert_array_equal(outcomes[0].goal, draw_task(scene, 5).goal)
    assert not outcomes[0].success
    assert outcomes[0].hidden == 0
