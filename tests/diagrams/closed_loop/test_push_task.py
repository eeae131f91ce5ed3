"""What is drawn at random for a run."""

from closed_loop_fixtures import closed_loop_scene
import numpy as np

from pbpf_drake.diagrams.closed_loop.push_task import draw_task


def test_goals_are_hidden_and_starts_are_not_and_both_are_random():
    scene = closed_loop_scene()
    tasks = [draw_task(scene, seed) for seed in range(30)]
    goals = np.array([task.goal for task in tasks])
    assert np.all(goals[:, 1] >= 0.2) and np.all(goals[:, 1] <= 0.36)
    assert len(np.unique(goals[:, 0])) == 30
    assert np.all(np.array([task.start for task in tasks])[:, 1] < -0.06)
    again = draw_task(scene, 3)
    np.testing.assert_array_equal(tasks[3].goal, again.goal)
