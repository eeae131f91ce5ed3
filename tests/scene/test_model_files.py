from mesh_fixtures import write_gantry, write_mesh
from pydrake.geometry import Mesh, Role
from pydrake.multibody.parsing import PackageMap, Parser
from pydrake.planning import RobotDiagramBuilder
import pytest

from pbpf_drake.scene.model_files import ReadableModels


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))


@pytest.fixture
def folder(tmp_path):
    """A ROS package with a wedge in several formats, a URDF file to come."""
    package = tmp_path / "gantry_description"
    (package / "meshes").mkdir(parents=True)
    for ending in ("stl", "dae", "obj"):
        write_mesh(package / "meshes" / f"wedge.{ending}")
    (package / "urdf").mkdir()
    return package / "urdf"


def _parsed(path):
    """The shapes of a model by role, as Drake has them."""
    builder = RobotDiagramBuilder(time_step=0.0)
    Parser(builder.plant()).AddModels(str(path))
    builder.plant().Finalize()
    inspector = builder.Build().scene_graph().model_inspector()
    return {
        role: [
            inspector.GetShape(g)
            for g in inspector.GetAllGeometryIds()
            if inspector.GetProperties(g, role) is not None
        ]
        for role in (Role.kProximity, Role.kIllustration)
    }


MESHES = "package://gantry_description/meshes/"


@pytest.mark.parametrize("collision", ["stl", "dae", "obj"])
@pytest.mark.parametrize("visual", ["stl", "dae", "obj"])
@pytest.mark.parametrize("where", [MESHES, "../meshes/", "file://{}/meshes/"])
def test_meshes_of_ros_become_meshes_of_drake(folder, collision, visual, where):
    base = where.format(folder.parent) + "wedge."
    write_gantry(
        folder / "a.urdf", collision=base + collision, visual=base + visual
    )
    models = ReadableModels(PackageMap())
    shapes = _parsed(models.Make(folder / "a.urdf"))
    for role in Role.kProximity, Role.kIllustration:
        (shape,) = shapes[role]
        assert isinstance(shape, Mesh)
        assert shape.extension() == ".obj"
    assert not models.warnings


def test_a_file_that_drake_can_read_is_not_copied(folder):
    path = folder / "a.urdf"
    write_gantry(path, collision="../meshes/wedge.obj")
    models = ReadableModels(PackageMap())
    assert models.Make(path) == path
    assert not models.originals


@pytest.mark.parametrize(
    "url, message",
    [
        ("package://nowhere/a.stl", "unknown package 'nowhere'"),
        ("../meshes/missing.stl", "which does not exist"),
        ("../meshes/broken.stl", "broken.stl has no triangles: is it whole"),
        ("../meshes/a.wrl", "ends in '.wrl'"),
        ("$(find x)/a.stl", "which does not exist"),
    ],
)
def test_what_collides_and_cant_be_read_is_named_with_file_and_link(
    folder, url, message
):
    for name in ("broken.stl", "a.wrl"):
        (folder.parent / "meshes" / name).write_text("broken")
    write_gantry(folder / "a.urdf", collision=url)
    with pytest.raises(ValueError, match=message) as error:
        ReadableModels(PackageMap()).Make(folder / "a.urdf")
    assert f"{folder / 'a.urdf'}: collision of link 'tool': " in str(
        error.value
    )


@pytest.mark.parametrize(
    "url", ["../meshes/missing.dae", "package://nowhere/a.dae", "a.wrl"]
)
def test_visuals_that_cant_be_read_are_left_out_and_said(folder, url):
    (folder / "a.wrl").write_text("")
    write_gantry(folder / "a.urdf", collision="../meshes/wedge.stl", visual=url)
    models = ReadableModels(PackageMap())
    shapes = _parsed(models.Make(folder / "a.urdf"))
    assert len(shapes[Role.kProximity]) == 1
    assert not shapes[Role.kIllustration]
    (warning,) = models.warnings
    assert "a.urdf: 1 visuals are left out of pictures: " in warning
    assert "(link tool)" in warning


def test_other_relative_paths_still_lead_to_the_same_file(folder):
    path = folder / "a.urdf"
    write_gantry(
        path, collision="../meshes/wedge.stl", visual="../meshes/wedge.obj"
    )
    text = ReadableModels(PackageMap()).Make(path).read_text()
    assert f'filename="{folder}/../meshes/wedge.obj"' in text


SDF = """<sdf version="1.7"><model name="wedge"><link name="wedge">
<collision name="c"><geometry><mesh><uri>{}</uri><scale>2 2 2</scale></mesh>
</geometry></collision></link></model></sdf>"""
INCLUDE = """<sdf version="1.7"><model name="outer">
<include><uri>{}</uri></include></model></sdf>"""


def test_sdf_files_are_made_readable_too_and_keep_their_scale(folder):
    path = folder / "a.sdf"
    path.write_text(SDF.format("../meshes/wedge.stl"))
    shapes = _parsed(ReadableModels(PackageMap()).Make(path))
    (shape,) = shapes[Role.kProximity]
    assert shape.extension() == ".obj"
    assert list(shape.scale3()) == [2, 2, 2]


def test_included_files_are_made_readable(folder):
    (folder / "a.sdf").write_text(SDF.format("../meshes/wedge.stl"))
    (folder / "b.sdf").write_text(INCLUDE.format("a.sdf"))
    shapes = _parsed(ReadableModels(PackageMap()).Make(folder / "b.sdf"))
    assert len(shapes[Role.kProximity]) == 1


def test_a_file_that_includes_itself_is_named(folder):
    (folder / "a.sdf").write_text(INCLUDE.format("b.sdf"))
    (folder / "b.sdf").write_text(INCLUDE.format("a.sdf"))
    with pytest.raises(ValueError, match=r"a\.sdf includes itself, th"):
        ReadableModels(PackageMap()).Make(folder / "a.sdf")


def test_prefixes_that_nobody_declares_are_no_obstacle(folder):
    path = folder / "a.urdf"
    write_gantry(path, collision="../meshes/wedge.stl")
    path.write_text(path.read_text().replace("<link", "<sensor:x/><link", 1))
    assert _parsed(ReadableModels(PackageMap()).Make(path))[Role.kProximity]


def test_parts_that_xacro_should_have_made_are_said(folder):
    path = folder / "a.urdf"
    write_gantry(path, collision="../meshes/wedge.obj")
    path.write_text(path.read_text().replace("<link", "<xacro:arm/><link", 1))
    models = ReadableModels(PackageMap())
    models.Make(path)
    (warning,) = models.warnings
    assert "elements of xacro (xacro:arm)" in warning
    assert "'xacro a.urdf > whole.urdf'" in warning


def test_an_expression_of_xacro_is_refused_with_the_remedy(folder):
    path = folder / "a.urdf"
    write_gantry(path, collision="../meshes/wedge.obj")
    path.write_text(
        path.read_text().replace('mass value="1"', 'mass value="${m}"')
    )
    message = r"a\.urdf: value of mass is '\$\{m\}'; .*'xacro a\.urdf >"
    with pytest.raises(ValueError, match=message):
        ReadableModels(PackageMap()).Make(path)


def test_a_xacro_file_is_refused_with_the_remedy(folder):
    (folder / "a.urdf.xacro").write_text("<robot/>")
    with pytest.raises(ValueError, match="xacro file; .*'xacro a.urdf.xacro"):
        ReadableModels(PackageMap()).Make(folder / "a.urdf.xacro")


def test_what_is_no_xml_is_left_to_drake(folder):
    (folder / "a.urdf").write_text("<robot")
    models = ReadableModels(PackageMap())
    assert models.Make(folder / "a.urdf") == folder / "a.urdf"


def test_messages_name_the_users_file(folder):
    path = folder / "a.urdf"
    write_gantry(path, collision="../meshes/wedge.stl")
    models = ReadableModels(PackageMap())
    copy = models.Make(path)
    assert models.OriginalNames(f"{copy}:3: error") == f"{path}:3: error"
