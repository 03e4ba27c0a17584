"""Which motion law for a lift in a third of a turn? `python cam.py cam.png`. Needs matplotlib."""

import sys

import matplotlib.pyplot as plt
import numpy as np

import coaxle

LAWS = ("polynom5", "polynom7", "bestehorn", "modsinuslinie", "beschltrapez")
STROKE, ANGLE, SPEED = 50.0, 120.0, 720.0  # mm, degrees, degrees/s

figure, axes = plt.subplots(3, 1, figsize=(8, 8), sharex=True, layout="constrained")
masters = np.linspace(0, ANGLE, 2001)
for name in LAWS:
    law = coaxle.Law(name, (0, 0), (ANGLE, STROKE))
    motion = law(masters)
    peaks = law.extremes()
    print(
        f"{name:14} {peaks['velocity'][1][0] * SPEED:8.1f} mm/s "
        f"{peaks['acceleration'][1][0] * SPEED**2:10.0f} mm/s² {peaks['jerk'][1][0] * SPEED**3:12.0f} mm/s³"
    )
    axes[0].plot(masters, motion.position, label=name)
    axes[1].plot(masters, motion.velocity * SPEED)
    axes[2].plot(masters, motion.acceleration * SPEED**2)
axes[0].set(ylabel="mm", title=f"{STROKE:g} mm in {ANGLE:g}° at {SPEED:g}°/s")
axes[1].set(ylabel="mm/s")
axes[2].set(ylabel="mm/s²", xlabel="master (°)")
axes[0].legend()
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "cam.png", dpi=120)
