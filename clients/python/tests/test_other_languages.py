"""The clients in MATLAB's language and in Julia on a running demo: what they read is what the site published, and what
they say where there is no bridge.
"""

import json
import shutil
import subprocess
from pathlib import Path

import numpy
import pytest
from conftest import free_port

CLIENTS = Path(__file__).parents[2]
MATLAB = r"""
pkg load instrument-control
addpath("{folder}")
try
  connection = sextant.connect("127.0.0.1", {port});
  do
    pose = sextant.receive(connection);
  until (strcmp(pose.type, "pose") && strcmp(pose.object, "cuboid"))
  printf("%d %s\n", pose.t_ns, jsonencode(rmfield(pose, "t_ns")));
catch failure
  printf("%s\n", failure.message);
end
"""
JULIA = """
include("{folder}/Sextant.jl")
try
    connection = Sextant.connect("127.0.0.1", {port})
    message = Dict()
    while get(message, "type", "") != "pose" || message["object"] != "cuboid"
        message = Sextant.receive(connection)
    end
    println(message["t_ns"], " ", Sextant.JSON.json(message))
catch failure
    println(sprint(showerror, failure))
end
"""


def has(*command):
    return shutil.which(command[0]) and subprocess.run(command, capture_output=True, check=False).returncode == 0


OCTAVE = pytest.param(
    ("octave-cli", "--quiet", "--eval"),
    MATLAB,
    "matlab",
    marks=pytest.mark.skipif(
        not has("octave-cli", "--eval", "pkg load instrument-control"),
        reason="needs octave-instrument-control: install it",
    ),
)
JULIA_ITSELF = pytest.param(
    ("julia", "-e"),
    JULIA,
    "julia",
    marks=pytest.mark.skipif(not has("julia", "-e", "using JSON"), reason="needs Julia with JSON"),
)


@pytest.mark.parametrize("interpreter, program, folder", [OCTAVE, JULIA_ITSELF])
class TestClient:
    def output(self, interpreter, program, folder, port):
        program = program.format(folder=CLIENTS / folder, port=port)
        done = subprocess.run([*interpreter, program], capture_output=True, text=True, timeout=120, check=False)
        return done.stdout.splitlines()[-1]

    def test_poses_are_those_that_were_published(self, interpreter, program, folder, ready, published):
        port = ready["page"].rsplit(":", 1)[1]
        t_ns, text = self.output(interpreter, program, folder, port).split(" ", 1)
        read = json.loads(text)
        close = lambda pose: numpy.allclose(
            [*pose.position, *pose.orientation], [*read["position"], *read["orientation"]], rtol=0, atol=1e-6
        )
        pose = published.find(lambda pose: pose.object == "cuboid" and pose.t_ns == int(t_ns) and close(pose))
        assert numpy.allclose(pose.covariance.ravel(), numpy.ravel(read["covariance"]), rtol=1e-3)

    def test_no_bridge_is_an_error(self, interpreter, program, folder):
        assert "connect" in self.output(interpreter, program, folder, free_port()).lower()

    def test_something_else_that_answers_is_an_error(self, interpreter, program, folder, ready):
        # Another host's name than the bridge's own.
        program = program.replace("127.0.0.1", "0.0.0.0")
        port = ready["page"].rsplit(":", 1)[1]
        assert "403" in self.output(interpreter, program, folder, port)
