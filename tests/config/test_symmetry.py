import numpy as np
import pytest

from pbpf_drake.config.scene_config import LoadScene
from pbpf_drake.config.symmetry import SymmetryConfig
from pbpf_drake.poses.quaternions import angle_between, rotate, to_matrix
from pbpf_drake.scene.scene_models import data_folder


def test_without_an_axis_there_is_only_the_turn_by_nothing():
    dut = SymmetryConfig()
    np.testing.assert_allclose(dut.turns(8), [[1, 0, 0, 0]])
    assert not dut.is_continuous()


def test_turns_map_a_square_prism_onto_itself():
    dut = SymmetryConfig(axis=[0, 0, 2], order=4)
    corners = np.array(np.meshgrid([-1, 1], [-1, 1], [-3, 3])).reshape(3, -1).T
    assert dut.turns(99).shape == (4, 4)
    for turned in rotate(dut.turns(99)[:, None], corners):
        gaps = np.linalg.norm(turned[:, None] - corners, axis=-1)
        np.testing.assert_allclose(gaps.min(axis=1), 0, atol=1e-12)


def test_turns_of_a_can_are_evenly_spaced_and_keep_its_axis():
    dut = SymmetryConfig(axis=[0, 1, 0])
    turns = dut.turns(12)
    assert dut.is_continuous() and len(turns) == 12
    np.testing.assert_allclose(to_matrix(turns)[:, 1, 1], 1)
    steps = angle_between(turns, np.roll(turns, -1, axis=0))
    np.testing.assert_allclose(steps, 2 * np.pi / 12)


@pytest.mark.parametrize(
    "field, value",
    [
        ("axis", [0.0, 0.0, 0.0]),
        ("axis", [1.0]),
        ("axis", [np.nan, 0.0, 1.0]),
        ("axis", [1e200, 0.0, 0.0]),
        ("axis", [1e-200, 0.0, 0.0]),
        ("order", -1),
        ("order", 10**9),
        ("order", 2),
    ],
)
def test_what_is_no_symmetry_is_refused_by_name(field, value):
    with pytest.raises(ValueError, match=f"soup.symmetry.{field} is .*expect"):
        SymmetryConfig(**{field: value}).ValidateOrThrow("soup.symmetry")


def test_a_scene_file_with_a_bad_symmetry_is_refused(tmp_path):
    path = data_folder("diagrams") / "scenes" / "planar_push.yaml"
    text = path.read_text().replace(
        "  block: {}", "  block: {symmetry: {order: -2}}"
    )
    (tmp_path / "bad.yaml").write_text(text)
    with pytest.raises(ValueError, match="tracked.block.symmetry.order is -2"):
        LoadScene(tmp_path / "bad.yaml")


def test_the_can_of_the_shipped_scene_has_its_axis():
    path = data_folder("diagrams") / "scenes" / "cheezit_gelatin_soup.yaml"
    tracked = LoadScene(path).tracked
    assert tracked["soup"].symmetry == SymmetryConfig(axis=[0.0, 1.0, 0.0])
    assert tracked["cracker"].symmetry == SymmetryConfig()
