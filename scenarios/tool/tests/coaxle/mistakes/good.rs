//! Files without a mistake.

pub(crate) const SENDER: &str = "\
name = 'conveyor'
cycle-time-us = 1000
[transport]
listen = ['tcp/127.0.0.1:0']
[real-time]
spin-us = 50
[[axis]]
id = 1
name = 'belt'
[axis.program]
start-velocity = 5
repeat = false
limits = { velocity = 10, acceleration = 10, jerk = 10 }
";

pub(crate) const RECEIVER: &str = "\
name = 'saw'
cycle-time-us = 1000
[[far]]
node = 'conveyor'
axes = [1]
mode = 'observer'
[real-time]
lock-memory = false
[[slave]]
name = 'carriage'
master = 'conveyor.1'
limits = { velocity = 10, acceleration = 10, jerk = 10 }
[[slave.step]]
label = 'begin'
do = { power = true }
[[slave.step]]
go-to = 'begin'
";

pub(crate) const SCENARIO: &str = "\
title = 'a test'
duration-s = 1
[[sender]]
name = 'conveyor'
cycle-time-us = 1000
[[sender.axis]]
id = 1
name = 'belt'
program = { limits = { velocity = 10, acceleration = 10, jerk = 10 } }
[[receiver]]
name = 'saw'
cycle-time-us = 1000
master.node = 'conveyor'
[[expect]]
receiver = 'saw'
field = 'errors'
at-most = 9
[[event]]
at-s = 0.5
node = 'conveyor'
action = 'freeze'
for-s = 0.1
";

pub(crate) const CAM: &str = "\
title = 'a rise'
[[point]]
master = 0
slave = 0
law = 'polynom5'
[[point]]
master = 180
slave = 10
";

pub(crate) const SAW: &str = "\
master = { position = 0, velocity = 100 }
slave = { position = 0, velocity = 0 }
[axis]
velocity = 1000
acceleration = 1000
jerk = 10000
[gear-in-velo]
ratio = { numerator = 1 }
";
