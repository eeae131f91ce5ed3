from pathlib import Path

from mesh_fixtures import write_gantry_scene
from pydrake.multibody.parsing import PackageMap
import pytest

from pbpf_drake.config.scene_config import LoadScene
from pbpf_drake.scene.model_packages import (
    AddAmentPackages,
    AddScenePackages,
    ResolveModelUrl,
)

XML = "<package><name>{}</name></package>"


def _mesh(folder: Path) -> Path:
    (folder / "meshes").mkdir(parents=True)
    (folder / "meshes" / "a.stl").write_text("")
    return folder / "meshes" / "a.stl"


def _scene(folder: Path, packages: str):
    return LoadScene(
        write_gantry_scene(folder, "a.urdf", more=f"packages: {packages}")
    )


def test_packages_of_ros_2_are_in_share_and_the_first_counts(
    tmp_path, monkeypatch
):
    first = _mesh(tmp_path / "one" / "share" / "arm_description")
    _mesh(tmp_path / "two" / "share" / "arm_description")
    other = _mesh(tmp_path / "two" / "share" / "hand_description")
    prefixes = [str(tmp_path / name) for name in ("one", "two", "missing")]
    monkeypatch.setenv("AMENT_PREFIX_PATH", ":".join([*prefixes, ""]))
    packages = PackageMap()
    AddAmentPackages(packages)
    for mesh in first, other:
        url = f"package://{mesh.parents[1].name}/meshes/a.stl"
        assert ResolveModelUrl(url, tmp_path, packages) == mesh


def test_without_ament_nothing_is_added(monkeypatch):
    monkeypatch.delenv("AMENT_PREFIX_PATH", raising=False)
    packages = PackageMap.MakeEmpty()
    AddAmentPackages(packages)
    assert not packages.GetPackageNames()


def test_a_scene_names_packages_relative_to_its_file(tmp_path):
    mesh = _mesh(tmp_path / "robots" / "arm")
    packages = PackageMap()
    AddScenePackages(packages, _scene(tmp_path, "{arm_meshes: robots/arm}"))
    url = "package://arm_meshes/meshes/a.stl"
    assert ResolveModelUrl(url, tmp_path, packages) == mesh


@pytest.mark.parametrize("packages", ["{arm: nowhere}", "{scene: .}"])
def test_a_package_of_a_scene_that_does_not_fit_is_named(tmp_path, packages):
    with pytest.raises(ValueError, match=r"packages\.\w+ is '.+'; expected"):
        AddScenePackages(PackageMap(), _scene(tmp_path, packages))


@pytest.mark.parametrize(
    "package, xml",
    [
        pytest.param("some_clone", True, id="package.xml above the model"),
        pytest.param("arm_description", False, id="a folder of its name"),
    ],
)
def test_a_models_own_package_is_found_where_the_model_is(
    tmp_path, package, xml
):
    mesh = _mesh(tmp_path / package)
    if xml:
        (tmp_path / package / "package.xml").write_text(
            XML.format("arm_description")
        )
    url = "package://arm_description/meshes/a.stl"
    folder = tmp_path / package / "urdf"
    assert ResolveModelUrl(url, folder, PackageMap()) == mesh


def test_a_package_beside_the_models_own_is_found(tmp_path):
    mesh = _mesh(tmp_path / "src" / "arm_description")
    url = "package://arm_description/meshes/a.stl"
    folder = tmp_path / "src" / "cell_description" / "urdf"
    assert ResolveModelUrl(url, folder, PackageMap()) == mesh


def test_a_folder_in_ros_package_path_needs_no_package_xml(
    tmp_path, monkeypatch
):
    mesh = _mesh(tmp_path / "src" / "arm_description")
    monkeypatch.setenv("ROS_PACKAGE_PATH", f"/nowhere:{tmp_path / 'src'}")
    url = "package://arm_description/meshes/a.stl"
    assert ResolveModelUrl(url, tmp_path / "x", PackageMap()) == mesh


@pytest.mark.parametrize(
    "url",
    [
        "meshes/a.stl",
        "{folder}/meshes/a.stl",
        "file://{folder}/meshes/a.stl",
        "file:{folder}/meshes/a.stl",
        "file:meshes/a.stl",
        "package://scene/meshes/a.stl",
        "model://scene/meshes/a.stl",
    ],
)
@pytest.mark.parametrize("name", ["plain", "my robot", "Käse"])
def test_every_way_to_name_a_file_works(tmp_path, url, name):
    mesh = _mesh(tmp_path / name)
    packages = PackageMap()
    packages.Add("scene", str(tmp_path / name))
    url = url.format(folder=tmp_path / name)
    assert ResolveModelUrl(url, tmp_path / name, packages) == mesh


def test_a_url_may_have_its_blanks_written_as_such(tmp_path):
    mesh = _mesh(tmp_path / "my robot")
    url = mesh.as_uri()
    assert "my%20robot" in url
    assert ResolveModelUrl(url, tmp_path, PackageMap()) == mesh


def test_an_unknown_package_is_named_with_all_remedies(tmp_path):
    url = "package://arm_description/a.stl"
    with pytest.raises(ValueError) as error:
        ResolveModelUrl(url, tmp_path, PackageMap())
    for part in (
        url,
        "unknown package 'arm_description'",
        "'packages: {arm_description: folder}'",
        "ROS_PACKAGE_PATH",
        "AMENT_PREFIX_PATH",
        "package://scene",
    ):
        assert part in str(error.value)


def test_what_is_missing_is_named_with_where_it_was_looked_for(tmp_path):
    missing = tmp_path / "meshes" / "a.stl"
    with pytest.raises(ValueError, match=f"'{missing}' which does not exist; "):
        ResolveModelUrl("meshes/a.stl", tmp_path, PackageMap())


def test_what_is_on_the_web_is_not_fetched(tmp_path):
    with pytest.raises(ValueError, match="begins with https://; .*download"):
        ResolveModelUrl("https://a.example/b.stl", tmp_path, PackageMap())
