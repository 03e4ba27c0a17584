"""A PLC of twenty lines: sends a cycle index and the image of an axis each 2 ms, and takes corrected ones."""
import socket, struct, sys, threading, time

listen, send_to = ("127.0.0.1", int(sys.argv[1])), ("127.0.0.1", int(sys.argv[2]))
seconds, cycle = float(sys.argv[3]), 0.002
out, into = (socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(2))
into.bind(listen)
into.settimeout(0.5)
start, errors = time.monotonic() + 0.1, []

def take():
    while time.monotonic() < start + seconds:
        try:
            index, image = struct.unpack("<H128s", into.recv(256))
        except TimeoutError:
            continue
        position, velocity = struct.unpack_from("<dd", image, 80)
        errors.append((position - 500.0 * (time.monotonic() - start), velocity))

threading.Thread(target=take, daemon=True).start()
for k in range(int(seconds / cycle)):
    time.sleep(max(0.0, start + k * cycle - time.monotonic()))
    image = bytearray(128)
    struct.pack_into("<I", image, 0, 3)                              # operational, homed
    struct.pack_into("<ddd", image, 80, 500.0 * k * cycle, 500.0, 0.0)  # set position, velocity, acceleration
    out.sendto(struct.pack("<H", k % 65536) + image, send_to)
print(len(errors), *(f"{error:.3f} {velocity:.3f}" for error, velocity in errors[-500:]), sep="\n")
