"""The beat and its cure: `python beat.py beat.png`. Needs matplotlib."""

import sys

import matplotlib.pyplot as plt

import coaxle

run = coaxle.run("beat", set={"duration-s": 40})
figure, axes = plt.subplots(figsize=(9, 4), layout="constrained")
for name in ("bypass", "sync"):
    table = run.table(name)
    axes.plot(table.time_s, table["truth.set_velocity"], label=name, linewidth=1)
axes.set(xlabel="time (s)", ylabel="set velocity (mm/s)", title=run.summary["title"])
axes.legend()
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "beat.png", dpi=120)
print("as expected" if run.passed else run.failures)
