"""A host of `romrun FILE --serve udp:PORT` with nothing but the standard library; the packets are those of docs/udp.md.

    python client.py PORT [STEPS]

damps the rotation of the body with a moment on its first point, one step for every exchange, and says how long an exchange takes.
"""

import os
import socket
import statistics
import struct
import sys
import time
import zlib

HELLO, NAME, STEP, READ, RESET, SNAPSHOT, RESTORE = range(1, 8)
REPLY, ERROR = 0x8000, 0xFFFF
DEAD, BODY = 0, 1  # frames of loads; 2 and on: section frames


class Client:
    """A session. Requests that get no reply are sent again, under the same number: they are not done twice."""

    def __init__(self, port, host="127.0.0.1", timeout=0.2, tries=10):
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.connect((host, port))
        self.socket.settimeout(timeout)
        self.tries, self.session, self.sequence = tries, int.from_bytes(os.urandom(4), "little"), 0
        fields = struct.unpack("<6Id", self.ask(HELLO))
        self.points, self.modes, self.sensors, self.motion, self.outputs, self.slots, self.dt = fields

    def ask(self, kind, payload=b""):
        self.sequence = (self.sequence + 1) & 0xFFFFFFFF
        packet = struct.pack("<4sHHIIII", b"ROMU", 1, kind, self.session, self.sequence, len(payload), 0) + payload
        packet += struct.pack("<I", zlib.crc32(packet))
        for _ in range(self.tries):
            try:
                self.socket.send(packet)
                while True:
                    reply = self.socket.recv(65535)
                    header = struct.unpack_from("<4sHHIIII", reply)
                    # Replies to what was asked before may still come in.
                    if header[3:5] == (self.session, self.sequence):
                        break
            except socket.timeout:
                continue
            except ConnectionRefusedError:  # nobody listens there yet
                time.sleep(self.socket.gettimeout())
                continue
            assert zlib.crc32(reply[:-4]) == struct.unpack("<I", reply[-4:])[0]
            if header[2] == ERROR:
                raise RuntimeError(reply[32:-4].decode())
            assert header[2] == kind | REPLY
            return reply[24:-4]
        raise TimeoutError("the server does not answer")

    def state(self, payload):
        (steps,) = struct.unpack_from("<Q", payload)
        return steps, struct.unpack_from(f"<{self.outputs}d", payload, 8)

    def name(self, what, index):
        return self.ask(NAME, struct.pack("<II", what, index)).decode()

    def step(self, wrenches=(), steps=1):
        """`wrenches`: (point, frame, force, moment) each."""
        loads = b"".join(struct.pack("<II6d", point, frame, *force, *moment) for point, frame, force, moment in wrenches)
        return self.state(self.ask(STEP, struct.pack("<II", steps, len(wrenches)) + loads))

    def read(self):
        return self.state(self.ask(READ))

    def reset(self, motion=()):
        """`motion`: position, velocity and angular velocity in A, attitude of A; 13 numbers."""
        return self.state(self.ask(RESET, struct.pack(f"<{len(motion)}d", *motion)))

    def snapshot(self, slot=0):
        return self.state(self.ask(SNAPSHOT, struct.pack("<I", slot)))

    def restore(self, slot=0):
        return self.state(self.ask(RESTORE, struct.pack("<I", slot)))


def main(port, steps):
    client = Client(port)
    print(f"{client.name(0, 0)}: {client.modes} modes, {client.points} points, dt = {client.dt} s")
    _, state = client.reset()
    took = []
    for _ in range(steps):
        w = state[13:16]  # angular velocity of A in A
        start = time.perf_counter()
        _, state = client.step([(0, BODY, (0, 0, 0), [-20 * x for x in w])])
        took.append(time.perf_counter() - start)
    print(f"t = {state[0]:.6f} s, r_G = ({state[1]:.9e}, {state[2]:.9e}, {state[3]:.9e}) m")
    took.sort()
    print(f"exchange: median {1e6 * statistics.median(took):.0f} us, longest {1e6 * took[-1]:.0f} us", file=sys.stderr)


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    main(int(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 1000)
