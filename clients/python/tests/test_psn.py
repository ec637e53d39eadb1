"""`sextant psn` on a running demo, read by two receivers of pypsn in the group: trackers have the names and poses of
the site's objects.
"""

import subprocess

import numpy
import pypsn
from conftest import free_port, running, wait_for


class Receiver:
    def __init__(self, port):
        self.packets = []
        self.receiver = pypsn.receiver(self.packets.append, "127.0.0.1", port)
        self.receiver.start()

    def newest(self, kind):
        return wait_for(lambda: next((packet for packet in reversed(self.packets) if isinstance(packet, kind)), None))


def test_trackers_are_the_objects_of_the_site(binary, demo, published):
    port = free_port()
    command = (binary, "psn", "--connect", demo, "--site", "demo", "--to", f"236.10.10.10:{port}")
    with running(*command, stderr=subprocess.PIPE, text=True) as process:
        assert "PosiStageNet" in process.stderr.readline()
        receivers = [Receiver(port), Receiver(port)]
        for receiver in receivers:
            info = receiver.newest(pypsn.psn_info_packet)
            assert info.name == b"Sextant" and (info.info.version_high, info.info.version_low) == (2, 3)
            names = {tracker.tracker_id: tracker.tracker_name.decode() for tracker in info.trackers}
            packet = receiver.newest(pypsn.psn_data_packet)
            assert packet.trackers
            for tracker in packet.trackers:
                x, y, z = tracker.pos
                # To the right, up, into the depth.
                position = numpy.float32([z, -x, y])

                def same(pose):
                    found = numpy.float32(pose.position)
                    return pose.object == names[tracker.id] and numpy.array_equal(found, position)

                pose = published.find(same)
                assert tracker.status == (1 if pose.state == "tracking" else tracker.status)
                length = numpy.linalg.norm(tuple(tracker.ori))
                assert abs(length - 2 * numpy.arccos(min(1, abs(pose.orientation[3])))) < 1e-3
    for receiver in receivers:
        receiver.receiver.running = False
        receiver.receiver.join()
