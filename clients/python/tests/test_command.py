"""Commands as child processes, without a site: how they are ended."""

import pytest
from sextant import _command
from sextant._command import Command

#: Prints a line, and goes on.
ENDLESS = "echo '{}'; while :; do sleep 0.05; done"


@pytest.fixture
def script(tmp_path, monkeypatch):
    """Makes lines of a shell the program that commands run."""
    program = tmp_path / "sextant"
    monkeypatch.setenv("SEXTANT_BINARY", str(program))

    def write(lines):
        program.write_text(f"#!/bin/sh\n{lines}\n")
        program.chmod(0o755)

    return write


def interrupt(*words):
    """The process of a command during which the program fails."""
    with pytest.raises(ZeroDivisionError):
        with Command(words) as command:
            next(command.lines())
            1 / 0
    return command._process


def test_an_error_lets_a_command_clean_up_unless_it_would_write_a_result(script):
    script(f"trap 'exit 7' TERM; {ENDLESS}")
    assert interrupt("demo").returncode == 7
    assert interrupt("calibrate", "rig", "--live").returncode == -9


def test_a_command_that_does_not_end_is_killed(script, monkeypatch):
    monkeypatch.setattr(_command, "GRACE_S", 0.1)
    script(f"trap '' TERM; {ENDLESS}")
    assert interrupt("demo").returncode == -9


def test_a_command_that_had_succeeded_before_it_was_closed_has_succeeded(script):
    script("echo '{}'")
    with Command(["check"]) as command:
        assert list(command.lines()) == [{}]
        command._process.wait()
        command.close()
        command.wait()
