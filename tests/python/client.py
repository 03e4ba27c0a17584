"""A node by docs/WIRE.md and nothing else: an axis at 100 Hz, time responses, a status. `pip install eclipse-zenoh`

python3 client.py NAME tcp/127.0.0.1:7447 [RECEIVER]     and it prints what the receiver says of it
"""
import json, secrets, struct, sys, time, zlib, zenoh

CYCLE, AXIS, VELOCITY, LATER = 10_000_000, 1, 10.0, 0           # ns, axis id, u/s, shown so many ns later

def varint(n):
    return bytes([n]) if n < 128 else bytes([n % 128 + 128]) + varint(n // 128)

def zigzag(n):
    return varint(2 * n if n >= 0 else -2 * n - 1)

def numbers(data):                                              # all varints of some bytes
    found, shift = [0], 0
    for b in data:
        found[-1] |= (b % 128) << shift
        shift = shift + 7 if b >= 128 else found.append(0) or 0
    return found[:-1]

def axis(number, position, velocity, state=1 << 9):
    return (b"".join(map(varint, [state, 0, 3, 0, 0, 1, 0, 0, number, 0, 0, 0])) + struct.pack("<2d", position, 0)
            + b"\0" + struct.pack("<7d", velocity, 0, position, velocity, 0, 0, 0) + b"\0\0\0")

def sealed(key, body):
    return body + struct.pack("<I", zlib.crc32(body, zlib.crc32(key.encode())))

def main(name, endpoint, receiver=None):
    config = zenoh.Config.from_json5(json.dumps({"listen": {"endpoints": [endpoint]}, "scouting": {"multicast": {"enabled": False}}}))
    session, start, epoch, sender = zenoh.open(config), time.monotonic_ns(), secrets.randbits(64), zlib.crc32(name.encode())
    key = lambda last: f"coaxle/{name}/{last}"
    tokens = [session.liveliness().declare_token(key(last)) for last in ("alive", f"runs/{epoch:016x}")]
    best = dict(priority=zenoh.Priority.REAL_TIME, congestion_control=zenoh.CongestionControl.DROP)
    axes, responses = (session.declare_publisher(key(last), **best) for last in ("axes", "time-responses"))
    stamp = lambda count: b"\1" + zigzag(time.monotonic_ns() - start - count * CYCLE)

    def respond(sample):
        t2, data = time.monotonic_ns() - start, bytes(sample.payload)
        if data[:1] == b"\1" and sealed(key("time-requests"), data[:-4]) == data:
            requester, run, number, ideal, _, left = numbers(data[1:-4])
            t1 = sum(n // 2 if n % 2 == 0 else -(n + 1) // 2 for n in (ideal, left))
            body = b"\1" + b"".join(map(varint, [sender, epoch, t2 // CYCLE, CYCLE, 1, requester, run, number]))
            responses.put(sealed(key("time-responses"), body + zigzag(t1) + zigzag(t2) + stamp(t2 // CYCLE)))

    requests = session.declare_subscriber(key("time-requests"), respond)
    watched = session.declare_subscriber(f"coaxle/{receiver}/status", lambda sample: print(
        json.loads(bytes(sample.payload)).get("far", {}).get(name), flush=True)) if receiver else None
    while True:
        count = (time.monotonic_ns() - start) // CYCLE + 1      # what was missed is skipped
        time.sleep(max(0, start + count * CYCLE - time.monotonic_ns()) / 1e9)
        fields = [sender, epoch, count % 65536, count, CYCLE] + [LATER] * (LATER > 0) + [1]
        body = bytes([1 + (LATER > 0)]) + b"".join(map(varint, fields))
        body += axis(AXIS, VELOCITY * count * CYCLE / 1e9, VELOCITY)
        axes.put(sealed(key("axes"), body + stamp(count)))
        if count % 25 == 0:
            session.put(key("status"), json.dumps({"node": name, "role": "sender", "health": "ok", "epoch": f"{epoch:016x}",
                "uptime_s": (time.monotonic_ns() - start) / 1e9, "cycle": count, "cycle_time_us": CYCLE / 1e3}))

if __name__ == "__main__":
    main(*sys.argv[1:])
