import pytest

from pbpf_drake.diagrams.jobs.run_command import RunCommand


def _raise(error: BaseException) -> None:
    raise error


def test_a_command_that_ends_well_says_nothing(capsys):
    done = []
    assert RunCommand("track", lambda: done.append(1)) == 0
    assert done == [1]
    assert capsys.readouterr() == ("", "")


@pytest.mark.parametrize("kind", [ValueError, FileNotFoundError])
def test_what_is_the_users_to_read_is_a_sentence(capsys, kind):
    assert RunCommand("track", lambda: _raise(kind("log.mcap: gone"))) == 1
    assert capsys.readouterr() == ("", "track: log.mcap: gone\n")


def test_an_interruption_is_said_and_has_its_exit_code(capsys):
    assert RunCommand("track", lambda: _raise(KeyboardInterrupt())) == 130
    assert capsys.readouterr() == ("", "track: interrupted\n")


def test_what_is_a_mistake_of_ours_is_not_hidden():
    with pytest.raises(ZeroDivisionError):
        RunCommand("track", lambda: _raise(ZeroDivisionError()))
