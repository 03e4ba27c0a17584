"""Records what a gateway and pyads's test server say to each other, byte for byte, for the test that replays it without either:

    cargo build --bin coaxle
    target/python/bin/python3 tests/gateway/record_ads.py target/debug/coaxle common/gateway/src/host/ads/recorded.txt

The server holds a cycle index and an axis that goes on each 100 ms. The gateway polls them, and writes two slaves of a receiver, which
has an axis of its own and so waits for nobody: the one as a structure, the other as set values. In the file each line is an AMS packet: `>` was sent by the gateway, `<` by the server, then
its bytes, two digits each.
"""
import importlib.metadata
import pathlib
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time

import pyads
from pyads.testserver import AdsTestServer, AdvancedHandler, PLCVariable

COAXLE, OUT = sys.argv[1:]
CYCLE, VELOCITY, SECONDS = 0.1, 500.0, 1.5
SERVER, PROXY, ZENOH = 48_977, 48_978, 48_979

GATEWAY = f"""
name = 'plc'
cycle-time-us = 100000
[transport]
connect = ['tcp/127.0.0.1:{ZENOH}']
[ads]
address = '127.0.0.1:{PROXY}'
net-id = '127.0.0.1.1.1'
own-net-id = '10.9.8.7.1.1'
cycle-index = 'GVL.nCycleIndex'
[[axis]]
id = 1
name = 'conveyor'
symbol = 'GVL.stConveyor'
[[output]]
node = 'saw'
channel = 'slaves'
cycle-index = 'GVL.nReceivedIndex'
[[output.axis]]
id = 1
symbol = 'GVL.stCorrected'
[[output.axis]]
id = 2
symbol = 'GVL.stSetValues'
image = 'external-set-values'
"""
RECEIVER = f"""
name = 'saw'
cycle-time-us = 50000
[transport]
listen = ['tcp/127.0.0.1:{ZENOH}']
[[virtual-axis]]
id = 1
name = 'shaft'
unit = 'mm'
[virtual-axis.program]
start-velocity = 250
limits = {{ velocity = 500, acceleration = 5000, jerk = 50000 }}
steps = []
[[slave]]
name = 'carriage'
[[slave]]
name = 'blade'
gear = {{ ratio = -2.0 }}
"""


class Plc(AdvancedHandler):
    """Requests are answered between two cycles, as a PLC does it."""

    between_cycles = threading.Lock()

    def handle_request(self, request):
        with self.between_cycles:
            return super().handle_request(request)


plc = Plc()


def variable(name, length):
    held = PLCVariable(name, bytes(length), pyads.constants.ADST_BIGTYPE, "ST")
    plc.add_variable(held)
    return held


index, conveyor = variable("GVL.nCycleIndex", 2), variable("GVL.stConveyor", 128)
for name, length in [("GVL.nReceivedIndex", 2), ("GVL.stCorrected", 128), ("GVL.stSetValues", 28)]:
    variable(name, length)


def turn():
    for k in range(1_000):
        image = bytearray(128)
        struct.pack_into("<I", image, 0, 3)
        struct.pack_into("<ddd", image, 80, VELOCITY * k * CYCLE, VELOCITY, 0.0)
        with plc.between_cycles:
            index.value, conveyor.value = struct.pack("<H", (65_530 + k) % 65_536), bytes(image)
        time.sleep(CYCLE)


def whole(connection, length):
    data = b""
    while len(data) < length:
        more = connection.recv(length - len(data))
        if not more:
            raise EOFError
        data += more
    return data


packets = []


def pass_on(mark, source, target):
    try:
        while True:
            header = whole(source, 6)
            packet = header + whole(source, struct.unpack_from("<I", header, 2)[0])
            packets.append(f"{mark} {packet.hex()}")
            target.sendall(packet)
    except (EOFError, OSError):
        target.close()


def proxy(listener):
    client, _ = listener.accept()
    server = socket.create_connection(("127.0.0.1", SERVER))
    for connection in (client, server):
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    threading.Thread(target=pass_on, args=("<", server, client), daemon=True).start()
    pass_on(">", client, server)


server = AdsTestServer(plc, "127.0.0.1", SERVER, logging=False)
server.start()
listener = socket.create_server(("127.0.0.1", PROXY))
threading.Thread(target=proxy, args=(listener,), daemon=True).start()
threading.Thread(target=turn, daemon=True).start()
with tempfile.TemporaryDirectory() as folder:
    configs = [pathlib.Path(folder, name) for name in ("receiver.toml", "gateway.toml")]
    for config, text in zip(configs, (RECEIVER, GATEWAY)):
        config.write_text(text)
    receiver = subprocess.Popen([COAXLE, "receiver", configs[0], "--for", "20s"])
    time.sleep(2)
    subprocess.run([COAXLE, "gateway", configs[1], "--for", f"{SECONDS}s"], check=True)
    receiver.terminate()
    receiver.wait()
versions = f"pyads {importlib.metadata.version('pyads')}, {subprocess.check_output([COAXLE, '--version'], text=True).strip()}"
head = f"# An ADS connection of a gateway (>) to the test server of pyads (<), a packet a line: made by tests/gateway/record_ads.py.\n# {versions}\n"
pathlib.Path(OUT).write_text(head + "\n".join(packets) + "\n")
print(f"{len(packets)} packets")
server.stop()
sys.exit(0)
