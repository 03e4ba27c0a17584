"""How well the phase observer follows, over jitter and loss: `python sweep.py sweep.png`. Needs matplotlib and pandas."""

import sys

import matplotlib.pyplot as plt

import coaxle

JITTER, LOSS = "network.jitter.exponential-us", "network.loss"
sweep = coaxle.sweep(
    "observer-sweep", {JITTER: [5, 10, 20, 50, 100], LOSS: [0.0, 0.1, 0.3]}, seeds=3, set={"duration-s": 20}
)
frame = sweep.frame()
figure_name = "corrected_time_error_settled_rms_us"
medians = frame.groupby([LOSS, JITTER])[figure_name].median().unstack(LOSS)
axes = medians.plot(marker="o", logx=True, logy=True, figsize=(7, 4))
axes.set(xlabel="mean jitter (µs)", ylabel=figure_name, title="The phase observer, medians of three seeds")
axes.legend(title="loss")
axes.figure.tight_layout()
axes.figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "sweep.png", dpi=120)
print(medians)
