"""`sextant mqtt` on a running demo, through Mosquitto, read by paho: poses, discovery by Home Assistant, events, the
last will, passwords, TLS, and a broker that comes back."""

import json
import shutil
import signal
import subprocess
from contextlib import contextmanager
from dataclasses import replace

import numpy
import paho.mqtt.client as mqtt
import pytest
import sextant
import zenoh
from conftest import free_port, running, wait_for

MOSQUITTO = shutil.which("mosquitto", path="/usr/sbin:/usr/bin:/usr/local/sbin:/opt/homebrew/sbin")
pytestmark = pytest.mark.skipif(MOSQUITTO is None, reason="needs mosquitto: install it")


class Subscriber:
    def __init__(self, port, **tls):
        self.messages = []
        self.client = mqtt.Client(mqtt.CallbackAPIVersion.VERSION2, protocol=mqtt.MQTTv5)
        if tls:
            self.client.tls_set(**tls)
            self.client.username_pw_set("site", "secret")
        self.client.on_message = lambda _client, _data, message: self.messages.append(message)
        self.client.on_connect = lambda client, *_: client.subscribe("#")
        self.client.connect("localhost", port)
        self.client.loop_start()

    def payload(self, topic, wanted=lambda payload: True):
        """The newest payload under a topic."""
        def newest():
            payloads = [m.payload.decode() for m in self.messages if m.topic == topic]
            return next((payload for payload in reversed(payloads) if wanted(payload)), None)

        return wait_for(newest)


@contextmanager
def broker(folder, port, *lines):
    file = folder / "mosquitto.conf"
    file.write_text(
        "\n".join(["user root", f"listener {port} localhost", *(lines or ["allow_anonymous true"])]) + "\n",
        encoding="utf-8",
    )
    with running(MOSQUITTO, "-c", file) as process:
        yield process


@contextmanager
def publisher(binary, demo, port, *options, scheme="mqtt", **more):
    address = f"{scheme}://localhost:{port}"
    command = (binary, "mqtt", "--connect", demo, "--site", "demo", "--to", address, *options)

    def ready():
        # The broker may not listen yet.
        process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, **more)
        if "publishing" in process.stderr.readline():
            return process
        process.wait()

    process = wait_for(ready)
    try:
        yield process
    finally:
        process.kill()
        process.wait()


def test_poses_discovery_events_and_the_end(binary, demo, published, tmp_path):
    port = free_port()
    with broker(tmp_path, port), publisher(binary, demo, port, "--home-assistant", "--rate", "20") as process:
        first, second = Subscriber(port), Subscriber(port)
        pose = json.loads(first.payload("sextant/demo/object/cuboid/pose"))
        # Each camera's image gives an estimate of an instant: one of them is it.
        same = published.find(
            lambda p: p.object == "cuboid"
            and p.t_ns == pose["t_ns"]
            and numpy.array_equal(p.position, pose["position"])
        )
        assert numpy.array_equal(same.orientation, pose["orientation"])
        assert second.payload("sextant/demo/object/cuboid/pose")
        assert first.payload("sextant/demo/status") == "online"

        device = json.loads(first.payload("homeassistant/device/sextant-demo-cuboid/config"))
        assert device["state_topic"] == "sextant/demo/object/cuboid/pose"
        assert device["availability_topic"] == "sextant/demo/status"
        ids = [component["unique_id"] for component in device["components"].values()]
        assert len(set(ids)) == len(ids) == 5

        event = {
            "sequence": 1,
            "t_ns": 1,
            "object": "cuboid",
            "event": "entered",
            "zone": "table",
            "position": [0, 0, 0],
        }
        config = zenoh.Config.from_json5(json.dumps({"mode": "client", "connect": {"endpoints": [demo]}}))
        with zenoh.open(config) as session:
            for payload in (b"\xff", b"[]", json.dumps(event).encode()):
                session.put("sextant/v1/demo/viewer/test/events", payload)
            assert json.loads(first.payload("sextant/demo/object/cuboid/event")) == event

        process.send_signal(signal.SIGINT)
        assert process.wait(60) == 0
        assert first.payload("sextant/demo/status", lambda status: status == "offline")


def test_a_removed_object_leaves_home_assistant(binary, demo, tmp_path):
    port, topic = free_port(), "homeassistant/device/sextant-demo-spare/config"
    with sextant.connect(demo, site="demo") as site:
        cuboid = site.objects()["cuboid"].config
        tag = replace(cuboid.tags[0], id=500)
        site.set(replace(cuboid, id="spare", tags=(tag,)))
        try:
            with broker(tmp_path, port), publisher(binary, demo, port, "--home-assistant"):
                subscriber = Subscriber(port)
                assert subscriber.payload(topic)
                site.remove_object("spare")
                wait_for(lambda: any(m.topic == topic and not m.payload for m in subscriber.messages))
                # It is not announced to those who come later.
                late = Subscriber(port)
                assert late.payload("homeassistant/device/sextant-demo-cuboid/config")
                assert topic not in [message.topic for message in late.messages]
        finally:
            if "spare" in site.objects():
                site.remove_object("spare")


def test_a_killed_publisher_is_offline(binary, demo, tmp_path):
    port = free_port()
    with broker(tmp_path, port):
        with publisher(binary, demo, port):
            assert Subscriber(port).payload("sextant/demo/status") == "online"
        assert Subscriber(port).payload("sextant/demo/status", lambda status: status == "offline")


def test_a_broker_that_restarts_gets_everything_again(binary, demo, tmp_path):
    port = free_port()
    with broker(tmp_path, port) as first:
        with publisher(binary, demo, port, "--home-assistant") as process:
            Subscriber(port).payload("sextant/demo/object/cuboid/pose")
            first.terminate()
            first.wait()
            assert "waiting for it" in process.stderr.readline()
            with broker(tmp_path, port):
                assert " is back" in process.stderr.readline()
                again = Subscriber(port)
                assert again.payload("sextant/demo/status") == "online"
                assert again.payload("homeassistant/device/sextant-demo-cuboid/config")
                assert again.payload("sextant/demo/object/cuboid/pose")


def test_tls_and_passwords(binary, demo, tmp_path):
    certificate, key, users = (str(tmp_path / name) for name in ("broker.pem", "broker.key", "users"))
    names = [
        "-subj",
        "/CN=localhost",
        "-addext",
        "subjectAltName=DNS:localhost",
        "-addext",
        "basicConstraints=critical,CA:FALSE",
        "-days",
        "2",
    ]
    files = ["-keyout", key, "-out", certificate]
    curve = ["-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes"]
    subprocess.run(["openssl", "req", "-x509", *curve, *names, *files], check=True, capture_output=True)
    subprocess.run(["mosquitto_passwd", "-b", "-c", users, "site", "secret"], check=True, capture_output=True)
    port = free_port()
    lines = [f"certfile {certificate}", f"keyfile {key}", f"password_file {users}", "allow_anonymous false"]
    options = ["--user", "site", "--password", "secret", "--ca", certificate]
    with broker(tmp_path, port, *lines):
        with publisher(binary, demo, port, *options, scheme="mqtts"):
            assert Subscriber(port, ca_certs=certificate).payload("sextant/demo/object/cuboid/pose")
        for wrong, words in [
            (["--user", "site", "--password", "guess", "--ca", certificate], "it refuses: "),
            (["--user", "site", "--password", "secret"], "invalid peer certificate"),
        ]:
            command = [binary, "mqtt", "--connect", demo, "--site", "demo", "--to", f"mqtts://localhost:{port}", *wrong]
            failed = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
            assert failed.returncode == 4 and words in failed.stderr, failed.stderr
