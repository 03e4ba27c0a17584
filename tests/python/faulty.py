"""A sender by docs/WIRE.md with one fault: what `coaxle conform sender` must find, and nothing besides.

python3 faulty.py NAME tcp/127.0.0.1:7447 [--fault FAULT]
python3 faulty.py --list          the faults, each with the rule that it breaks
"""
import json, secrets, struct, sys, time, zlib

# Each fault, and the rule that it breaks.
FAULTS = {
    "version-3": "version",
    "version-2-without-its-field": "fields",
    "cut-short": "fields",
    "extra-byte": "fields",
    "sum-without-key": "check-sum",
    "sum-of-other-key": "check-sum",
    "other-sender": "sender-id",
    "epoch-drawn-again": "epoch",
    "epoch-kept-at-restart": "epoch",
    "cycle-time-too-long": "cycle-time",
    "cycle-time-changes": "cycle-time",
    "count-twice": "count",
    "index-stands": "index",
    "fast-clock": "pace",
    "half-the-frames": "every-cycle",
    "bursts": "no-bursts",
    "stamp-now-and-then": "stamp-present",
    "stamp-zero": "stamp-range",
    "stamp-of-the-day": "stamp-range",
    "stamps-cross": "stamp-order",
    "axis-twice": "axis-ids",
    "axes-swap": "axis-order",
    "not-a-number": "axis-numbers",
    "both-directions": "axis-state",
    "velocity-per-minute": "axis-velocity",
    "answers-of-other-epoch": "answer-frame",
    "answers-late": "answer-time",
    "answers-other-number": "answer-echo",
    "answers-anything": "answer-once",
    "answers-twice": "answer-once",
    "answers-before-asked": "answer-stamps",
    "status-no-json": "status-json",
    "status-without-health": "status-fields",
    "status-of-other-epoch": "status-true",
    "status-once": "status-pace",
    "no-alive-token": "alive",
    "token-of-other-run": "run-token",
    "background-priority": "qos",
    "blocking": "qos",
    "shown-too-late": "present-after",
}

CYCLE = 10_000_000  # ns
AXES = (1, 2)
VELOCITY = 10.0  # u/s


class Sender:
    def __init__(self, name, endpoint, fault):
        import zenoh
        from client import axis, numbers, sealed, varint, zigzag

        self.axis, self.numbers, self.sealed, self.varint, self.zigzag = axis, numbers, sealed, varint, zigzag
        self.name, self.fault = name, fault
        config = {"listen": {"endpoints": [endpoint]}, "scouting": {"multicast": {"enabled": False}}}
        self.session = zenoh.open(zenoh.Config.from_json5(json.dumps(config)))
        self.waiting, self.is_heard = [], False
        self.id, self.epoch = zlib.crc32(name.encode()), secrets.randbits(64)
        self.begun = self.start = time.monotonic_ns()
        quality = {"priority": zenoh.Priority.REAL_TIME, "congestion_control": zenoh.CongestionControl.DROP}
        if self.has("background-priority"):
            quality["priority"] = zenoh.Priority.BACKGROUND
        if self.has("blocking"):
            quality["congestion_control"] = zenoh.CongestionControl.BLOCK
        run = self.epoch ^ self.has("token-of-other-run")
        lasts = [f"runs/{run:016x}"] + ["alive"] * (not self.has("no-alive-token"))
        self.tokens = [self.session.liveliness().declare_token(self.key(last)) for last in lasts]
        self.axes = self.session.declare_publisher(self.key("axes"), **quality)
        self.responses = self.session.declare_publisher(self.key("time-responses"), **quality)
        self.requests = self.session.declare_subscriber(self.key("time-requests"), self.respond)

    def has(self, fault):
        return self.fault == fault

    def key(self, last):
        return f"coaxle/{self.name}/{last}"

    def now(self):
        """Nanoseconds since the ideal start of cycle 0, of the clock of this node."""
        passed = time.monotonic_ns() - self.start
        return passed + passed // 50 if self.has("fast-clock") else passed

    def sleep_until(self, ns):
        left = ns - self.now()
        time.sleep(max(0, left / 1e9 / (1.02 if self.has("fast-clock") else 1)))

    def prefix(self, fields):
        return b"\1" + b"".join(map(self.varint, fields))

    def stamp(self, ns):
        return b"\1" + self.zigzag(ns)

    # Frames

    def frame(self, count):
        index = 7 if self.has("index-stands") else count % 65536
        cycle = CYCLE
        if self.has("cycle-time-too-long"):
            cycle = 200_000_000
        if self.has("cycle-time-changes") and self.is_heard and count % 20 == 0:
            cycle *= 2
        axes = self.axes_of(count)
        fields = [self.id ^ self.has("other-sender"), self.epoch, index, count, cycle]
        if self.has("shown-too-late"):
            # 5 s do not even fit into 32 bits; this is above the 4 s that do.
            return b"\2" + self.prefix(fields + [4_200_000_000, len(axes)])[1:] + b"".join(axes) + self.frame_stamp(count)
        return self.prefix(fields + [len(axes)]) + b"".join(axes) + self.frame_stamp(count)

    def axes_of(self, count):
        velocity = VELOCITY
        position = VELOCITY * count * CYCLE / 1e9
        if self.has("velocity-per-minute"):
            velocity *= 60
        if self.has("not-a-number"):
            velocity = float("nan")
        state = 3 << 9 if self.has("both-directions") else 1 << 9
        ids = AXES
        if self.has("axis-twice"):
            ids = (1, 1)
        if self.has("axes-swap") and count % 2:
            ids = (2, 1)
        return [self.axis(id, position, velocity, state) for id in ids]

    def frame_stamp(self, count):
        late = self.now() - count * CYCLE
        if self.has("stamp-now-and-then") and count % 3 == 0:
            return b"\0"
        if self.has("stamp-zero"):
            late = 0
        if self.has("stamp-of-the-day"):
            late = time.time_ns()
        if self.has("stamps-cross"):
            late = CYCLE * 8 // 10 * (1 if count % 2 else -1)
        return self.stamp(late)

    def send(self, count):
        if self.has("half-the-frames") and count % 2:
            return
        body = self.frame(count)
        key = self.key("axes")
        if self.has("version-3"):
            body = b"\3" + body[1:]
        if self.has("version-2-without-its-field"):
            body = b"\2" + body[1:]
        if self.has("cut-short"):
            body = body[:-20]
        if self.has("extra-byte"):
            body += b"\0"
        frame = self.sealed(self.key("slaves") if self.has("sum-of-other-key") else key, body)
        if self.has("sum-without-key"):
            frame = body + struct.pack("<I", zlib.crc32(body))
        for _ in range(2 if self.has("count-twice") and count % 10 == 0 else 1):
            self.axes.put(frame)

    # Time requests

    def respond(self, sample):
        received, data = self.now(), bytes(sample.payload)
        self.is_heard = True
        is_good = data[:1] == b"\1" and self.sealed(self.key("time-requests"), data[:-4]) == data
        if not is_good and not self.has("answers-anything"):
            return
        requester, run, number, ideal, _, left = self.numbers(data[1:-4])
        asked = sum(n // 2 if n % 2 == 0 else -(n + 1) // 2 for n in (ideal, left))
        self.waiting.append((received, [requester, run, number + self.has("answers-other-number") * 1000], asked))
        if not self.has("answers-late"):
            self.answer()

    def answer(self):
        waiting, self.waiting = self.waiting, []
        for received, request, asked in waiting:
            count = self.now() // CYCLE
            epoch = self.epoch ^ self.has("answers-of-other-epoch")
            if self.has("answers-before-asked"):
                received += 400_000_000
            body = self.prefix([self.id, epoch, count, CYCLE, 1] + request) + self.zigzag(asked) + self.zigzag(received)
            body += self.stamp(self.now() - count * CYCLE)
            for _ in range(1 + self.has("answers-twice")):
                self.responses.put(self.sealed(self.key("time-responses"), body))

    # Status

    def tell(self, count):
        epoch = self.epoch ^ self.has("status-of-other-epoch")
        status = {"node": self.name, "role": "sender", "health": "ok", "epoch": f"{epoch:016x}",
                  "uptime_s": (time.monotonic_ns() - self.begun) / 1e9, "cycle": count, "cycle_time_us": CYCLE / 1e3}
        if self.has("status-without-health"):
            del status["health"]
        text = json.dumps(status)
        self.session.put(self.key("status"), text[:-1] if self.has("status-no-json") else text)

    def run(self):
        told = 0
        while True:
            count = self.now() // CYCLE + 1
            if self.has("bursts"):
                # Ten cycles at a time, when the last of them begins.
                count = (count // 10 + 1) * 10
            self.sleep_until(count * CYCLE)
            if self.has("epoch-drawn-again") and self.is_heard and count % 50 == 0:
                self.epoch = secrets.randbits(64)
                self.tokens[0].undeclare()
                self.tokens[0] = self.session.liveliness().declare_token(self.key(f"runs/{self.epoch:016x}"))
            for late in range(count - 9, count + 1) if self.has("bursts") else [count]:
                self.send(late)
            if self.has("answers-late") and count % 40 == 0:
                self.answer()
            if self.now() >= told and not (self.has("status-once") and told):
                self.tell(count)
                told = self.now() + 250_000_000
            if self.has("epoch-kept-at-restart") and self.is_heard and count >= 150:
                self.start, told = time.monotonic_ns(), 0


def main(words):
    if words == ["--list"]:
        print(json.dumps(FAULTS))
        return
    fault = words[3] if words[2:3] == ["--fault"] else None
    if fault not in (None, *FAULTS):
        sys.exit(f"received --fault {fault}, expected one of {', '.join(FAULTS)}")
    Sender(words[0], words[1], fault).run()


if __name__ == "__main__":
    main(sys.argv[1:])
