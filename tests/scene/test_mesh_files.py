import os

from mesh_fixtures import write_dae
import pytest
import trimesh

from pbpf_drake.scene import mesh_files
from pbpf_drake.scene.mesh_files import CacheFolder, ReadableMesh


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path / "cache" / "pbpf_drake"


def test_what_drake_reads_itself_is_left_as_it_is(tmp_path):
    for name in ("a.obj", "a.OBJ", "a.gltf", "a.vtk"):
        (tmp_path / name).write_text("")
        assert ReadableMesh(tmp_path / name, hull=True) == tmp_path / name


def test_a_mesh_is_converted_once_and_again_when_it_changes(
    tmp_path, monkeypatch, cache
):
    path = tmp_path / "wedge.dae"
    write_dae(path)
    first = ReadableMesh(path, hull=True)
    with monkeypatch.context() as patch:
        patch.setattr(trimesh, "load_scene", None)
        assert ReadableMesh(path, hull=True) == first
    write_dae(path, moved="1 0 0")
    assert ReadableMesh(path, hull=True) != first
    assert len(list(cache.iterdir())) == 2


def test_a_pipe_is_no_mesh(tmp_path):
    os.mkfifo(tmp_path / "a.stl")
    with pytest.raises(ValueError, match=r"a\.stl is no file"):
        ReadableMesh(tmp_path / "a.stl", hull=True)


def test_without_a_cache_a_temporary_folder_is_used(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    assert CacheFolder().is_dir()
    assert CacheFolder() == mesh_files._temporary_folder()


def test_a_mesh_of_an_unknown_kind_is_refused_with_the_known_ones(tmp_path):
    (tmp_path / "a.wrl").write_text("")
    with pytest.raises(ValueError, match=r"'\.wrl'; expected .*\.stl, \.dae"):
        ReadableMesh(tmp_path / "a.wrl", hull=True)


def test_nothing_is_kept_of_a_mesh_that_cant_be_converted(tmp_path, cache):
    (tmp_path / "a.dae").write_text("no XML")
    with pytest.raises(ValueError, match=r"a\.dae can't be read as DAE"):
        ReadableMesh(tmp_path / "a.dae", hull=True)
    assert not list(cache.iterdir())
