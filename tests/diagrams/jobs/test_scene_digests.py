"""What counts as a scene's files."""

from pathlib import Path

import pytest

from pbpf_drake.diagrams.jobs.scene_digests import ReadSceneFiles
from pbpf_drake.diagrams.jobs.scene_run import scene_name, scene_path
from pbpf_drake.scene.scene_models import data_folder

SCENES = data_folder("diagrams") / "scenes"
CRACKER = "package://pbpf_drake/cracker/cracker.sdf"


def _digests(folder: Path, **changes: str) -> tuple[str, str]:
    """Returns those of a copy of a scene, with the text of it changed."""
    text = (SCENES / "cheezit_1.yaml").read_text()
    for old, new in changes.items():
        assert text.count(old) == 1
        text = text.replace(old, new)
    folder.mkdir(exist_ok=True)
    (folder / "own.yaml").write_text(text)
    files = ReadSceneFiles(str(folder / "own.yaml"))
    return files.recorded_digest, files.tracked_digest


def test_scenes_have_names_or_are_files(tmp_path):
    assert scene_path("cheezit_1") == SCENES / "cheezit_1.yaml"
    own = str(tmp_path / "own.yaml")
    assert scene_path(own) == Path(own)
    assert scene_name(own) == "own" and scene_name("soup_1") == "soup_1"


def test_digests_change_with_the_scene_but_not_with_its_comments(tmp_path):
    recorded, tracked = _digests(tmp_path)
    # The log holds what recording says.
    new = _digests(tmp_path, **{"stddev: 0.006": "stddev: 0.007"})
    assert new[0] != recorded and new[1] == tracked
    new = _digests(tmp_path, **{"fx: 605.904": "fx: 600.0"})
    assert new[0] != recorded and new[1] != tracked
    # The filter's configuration is in the key of a result by itself.
    new = _digests(
        tmp_path, **{"robot: panda\n": "robot: panda\nfilter: {seed: 9}\n"}
    )
    assert new == (recorded, tracked)
    new = _digests(tmp_path, **{"robot: panda\n": "# Hello.\nrobot: panda\n"})
    assert new == (recorded, tracked)


def test_digests_change_with_the_files_of_the_models(tmp_path):
    sdf = (data_folder("models") / "cracker" / "cracker.sdf").read_text()
    found = set()
    for mass in "0.411", "0.5":
        (tmp_path / "cracker.sdf").write_text(sdf.replace("0.411", mass))
        found.add(
            _digests(tmp_path, **{CRACKER: "package://scene/cracker.sdf"})
        )
    assert len(found) == 2


@pytest.mark.parametrize(
    "reference",
    [
        "<uri>meshes/box.obj</uri>",
        "<uri>package://scene/models/meshes/box.obj</uri>",
        "<include><uri>meshes</uri></include>",
        "<mesh filename='meshes/box.obj'/>",
    ],
)
def test_digests_change_with_what_a_model_refers_to(reference, tmp_path):
    meshes = tmp_path / "models" / "meshes"
    meshes.mkdir(parents=True)
    (tmp_path / "models" / "own.sdf").write_text(f"<sdf>{reference}</sdf>")
    found = set()
    for content in "v 0 0 0", "v 0 0 1":
        (meshes / "box.obj").write_text(content)
        found.add(
            _digests(tmp_path, **{CRACKER: "package://scene/models/own.sdf"})
        )
    assert len(found) == 2


def test_digests_change_with_directives_in_another_file(tmp_path):
    added = "add_directives: {file: package://scene/more.dmd.yaml}"
    found = set()
    for mass in "0.4", "0.5":
        (tmp_path / "more.dmd.yaml").write_text(
            "directives:\n- add_frame:\n    name: f\n    X_PF:\n"
            f"      base_frame: world\n      translation: [0, 0, {mass}]\n"
        )
        found.add(
            _digests(tmp_path, **{"directives:\n": f"directives:\n- {added}\n"})
        )
    assert len(found) == 2


@pytest.mark.parametrize(
    "url", ["package://nowhere/a.sdf", "package://scene/none/a.sdf"]
)
def test_a_model_that_is_not_there_is_said_with_the_scene(url, tmp_path):
    with pytest.raises(ValueError, match=rf"own\.yaml: .*'{url}'"):
        _digests(tmp_path, **{CRACKER: url})
