"""Files of runs."""

import pathlib
import stat

import pytest

from c3rt.evaluation.files import hash_of_files, tail, write_text


@pytest.fixture
def model(tmp_path):
    """A MuJoCo model that has a mesh in a folder of its own."""
    (tmp_path / "meshes").mkdir()
    (tmp_path / "meshes/t.obj").write_text("v 0 0 0\n")
    (tmp_path / "t.xml").write_text('<mujoco><compiler meshdir="meshes"/><mesh file="t.obj"/></mujoco>')
    return tmp_path / "t.xml"


def test_a_changed_model_is_another_run_the_same_text_again_is_the_same_run(model):
    before = hash_of_files([str(model)])
    assert hash_of_files([str(model)]) == before
    model.write_text("<mujoco><compiler meshdir='meshes'/><mesh file='t.obj' /></mujoco>")
    assert hash_of_files([str(model)]) != before


def test_so_is_a_changed_mesh_that_the_model_names(model):
    before = hash_of_files([str(model)])
    (model.parent / "meshes/t.obj").write_text("v 0 0 1\n")
    assert hash_of_files([str(model)]) != before


def test_what_nothing_names_does_not_count_and_a_model_that_includes_itself_ends(model):
    before = hash_of_files([str(model)])
    other = model.parent / "other.xml"
    other.write_text('<mujoco><include file="other.xml"/></mujoco>')
    assert hash_of_files([str(model)]) == before
    assert hash_of_files([str(other)]) != hash_of_files([str(model.parent / "not_there.xml")])


def test_a_file_is_written_whole_keeps_its_rights_and_a_link_stays_one(tmp_path):
    file, link = tmp_path / "a.json", tmp_path / "link.json"
    write_text(file, "first\n")
    file.chmod(0o640)
    link.symlink_to("a.json")
    write_text(link, "über\n")
    assert link.is_symlink() and file.read_text(encoding="utf-8") == "über\n"
    assert stat.S_IMODE(file.stat().st_mode) == 0o640
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.json", "link.json"]


def test_a_file_that_cannot_be_written_is_named_with_the_reason():
    with pytest.raises(RuntimeError, match="cannot write /no/such/folder/a.json: No such file"):
        write_text(pathlib.Path("/no/such/folder/a.json"), "")


def test_the_tail_of_a_log_is_its_last_lines(tmp_path):
    (tmp_path / "log").write_text("one\ntwo\nthree")
    assert tail(tmp_path / "log", 2) == "two\nthree\n"
    assert tail(tmp_path / "none", 2) == ""
