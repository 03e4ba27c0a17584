//! Texts of the two configs.

use super::answers::PlacedNode;
use super::{FollowerTask, NETWORK, StartPlan};

const LEAD_PORT: u16 = 7447;
const FOLLOW_PORT: u16 = 7448;

const PROGRAM: &str = r#"[[axis]]
id = 1
name = "belt"
unit = "mm"
# With this, every follower shows it that much later, at the same instant, and predicts nothing: docs/PRESENTATION.md
# present-after-ms = 20

# A motion to begin with. [axis.encoder] measures one, [axis.replay] repeats one.
[axis.program]
limits = { velocity = 1000, acceleration = 1000, jerk = 10000 }
steps = [{ enable = true }, { velocity = { value = 500 } }]
"#;

const GEAR: &str = r#"[[slave]]
name = "roll"
unit = "mm"
gear = { ratio = 1 }
limits = { velocity = 2000, acceleration = 20000, jerk = 1000000 }
# With a drive in another process: docs/DRIVE.md. Its dead time, if it has one:
# dead-time-us = 4000
"#;

const SAW: &str = r#"[[slave]]
name = "carriage"
unit = "mm"
couple = "off"
limits = { velocity = 1500, acceleration = 10000, jerk = 200000, min-position = -50, max-position = 1000 }
# With a drive in another process: docs/DRIVE.md. Its dead time, if it has one:
# dead-time-us = 4000

[[slave.step]]
when = { master-ready = true }
do = { power = true }

[[slave.step]]
label = "couple, 400 mm of the belt from now on"
do = { gear-in-pos = { ratio = { numerator = 1 }, master-sync-position = { ahead = 400 }, slave-sync-position = 200 } }

[[slave.step]]
label = "cut"
when = { in-sync = true, position-above = 350 }
cut = true

[[slave.step]]
label = "uncouple"
when = { position-above = 500 }
do = { gear-out = {} }

[[slave.step]]
label = "return"
do = { move-absolute = { position = 0, velocity = 800, dynamics = { acceleration = 9000, jerk = 200000 } } }

[[slave.step]]
when = { position-below = 1 }
repeat-from = "couple, 400 mm of the belt from now on"
"#;

pub(super) fn sender_config(plan: &StartPlan) -> String {
    let StartPlan {
        lead,
        cycle_time_us,
        ..
    } = plan;
    let name = &lead.name;
    let transport = transport(plan, lead, LEAD_PORT, None);
    format!(
        "# {name} leads. Start it with: coaxle sender {name}.toml\nname = \"{name}\"\ncycle-time-us = {cycle_time_us}\n\n\
         {transport}\n{PROGRAM}"
    )
}

pub(super) fn receiver_config(plan: &StartPlan) -> String {
    let StartPlan {
        lead,
        follow,
        task,
        cycle_time_us,
        ..
    } = plan;
    let (name, master) = (&follow.name, &lead.name);
    let slaves = match task {
        FollowerTask::Gear => GEAR,
        FollowerTask::Saw => SAW,
        FollowerTask::Watch => "",
    };
    // Without a list it would have one that follows by a gear.
    let none = match task {
        FollowerTask::Watch => "slave = []\n",
        _ => "",
    };
    let transport = transport(plan, follow, FOLLOW_PORT, Some(lead));
    format!(
        "# {name} follows {master}. Start it with: coaxle receiver {name}.toml\nname = \"{name}\"\ncycle-time-us = {cycle_time_us}\n\
         master = {{ node = \"{master}\", axis = 1, unit = \"mm\" }}\n{none}\n{transport}\n{slaves}"
    )
}

/// The section of a node that listens at `port`, and connects to another one.
fn transport(plan: &StartPlan, node: &PlacedNode, port: u16, to: Option<&PlacedNode>) -> String {
    let protocol = if plan.is_secure { "tls" } else { "tcp" };
    // Without certificates only a node that others connect to listens beyond its PC.
    let is_open = !node.is_local() && (plan.is_secure || to.is_none());
    let at = if is_open { "0.0.0.0" } else { "127.0.0.1" };
    let mut text = String::from("[transport]\n");
    if is_open && !plan.is_secure {
        text += "# Anybody who reaches this port can take part: docs/SECURE.md\n";
    }
    text += &format!("listen = [\"{protocol}/{at}:{port}\"]\n");
    if let Some(to) = to {
        text += &format!("connect = [\"{}\"]\n", to.endpoint(protocol, LEAD_PORT));
    }
    if plan.is_secure {
        text += &format!("secure = \"{NETWORK}/{}\"\n", node.name);
    }
    text
}
