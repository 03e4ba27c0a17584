"""A PLC behind pyads's test server: counts a cycle index and moves an axis each 5 ms, and looks at what it gets back.

    plc_ads.py PORT SECONDS
"""
import struct
import sys
import threading
import time

import pyads
from pyads.testserver import AdsTestServer, AdvancedHandler, PLCVariable

CYCLE, VELOCITY = 0.005, 500.0
port, seconds = int(sys.argv[1]), float(sys.argv[2])


class Plc(AdvancedHandler):
    """Requests are answered between two cycles, as a PLC does it."""

    between_cycles = threading.Lock()

    def handle_request(self, request):
        with self.between_cycles:
            # The server keeps every request; nobody reads them.
            server.request_history.clear()
            return super().handle_request(request)


def variable(name, length):
    held = PLCVariable(name, bytes(length), pyads.constants.ADST_BIGTYPE, "ST")
    plc.add_variable(held)
    return held


plc = Plc()
server = AdsTestServer(plc, "127.0.0.1", port, logging=False)
index, conveyor = variable("GVL.nCycleIndex", 2), variable("GVL.stConveyor", 128)
received, corrected = variable("GVL.nReceivedIndex", 2), variable("GVL.stCorrected", 128)
server.start()
start, errors, before = time.monotonic() + 0.1, [], bytes(2)
for k in range(int(seconds / CYCLE)):
    time.sleep(max(0.0, start + k * CYCLE - time.monotonic()))
    image = bytearray(128)
    struct.pack_into("<I", image, 0, 3)
    struct.pack_into("<ddd", image, 80, VELOCITY * k * CYCLE, VELOCITY, 0.0)
    with plc.between_cycles:
        index.value, conveyor.value = struct.pack("<H", (65000 + k) % 65536), bytes(image)
        if received.value != before:
            before = received.value
            position, velocity = struct.unpack_from("<dd", corrected.value, 80)
            errors.append((position - VELOCITY * (time.monotonic() - start), velocity))
print(len(errors), *(f"{error:.3f} {velocity:.3f}" for error, velocity in errors[-200:]), sep="\n")
