"""A node that runs, followed: `python follow.py conveyor 1 tcp/127.0.0.1:7447`."""

import sys

import coaxle

node, axis, endpoint = (*sys.argv[1:], "conveyor", "1", "tcp/127.0.0.1:7447")[:3]
with coaxle.Network([endpoint]) as network, network.follow(node, axes=[int(axis)]) as follower:
    while follower.wait(50, within_s=5.0):
        read = follower.read()
        now = read.axes[int(axis)]
        print(f"{now.position:10.3f} {now.velocity:8.3f}  sure: {read.is_sure}  ± {read.uncertainty_s or 0:.1e} s")
print(f"nothing of {node} for 5 s")
