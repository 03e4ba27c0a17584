use super::*;
use crate::node_config::{NodeConfig, NodeKind};

fn args(folder: &Path, lead: &str, follow: &str, task: FollowerTask) -> InitArgs {
    let node = |text: &str| Some(PlacedNode::read(text).expect("a node"));
    InitArgs {
        folder: folder.to_owned(),
        lead: node(lead),
        follow: node(follow),
        task: Some(task),
        secure: None,
        cycle_time_us: 2_000,
    }
}

fn written(args: &InitArgs) -> anyhow::Result<StartPlan> {
    let plan = plan(args, &Interview::new(false))?;
    make_empty(&args.folder)?;
    write(&args.folder, &plan)?;
    check(&args.folder, &plan)?;
    Ok(plan)
}

#[test]
fn every_task_gives_two_configs_that_fit() {
    for task in [FollowerTask::Gear, FollowerTask::Saw, FollowerTask::Watch] {
        let scratch = tempfile::tempdir().expect("a scratch folder");
        let folder = scratch.path().join("new");
        let plan = written(&args(&folder, "line", "roll", task)).expect("two configs");
        assert!(!plan.is_secure);
        let [lead, follow] = configs_of(&folder, &plan).map(|file| NodeConfig::load(&file));
        let (Ok(lead), Ok(follow)) = (lead, follow) else {
            panic!("{task:?}: not read again");
        };
        assert_eq!(lead.transport().listen, ["tcp/127.0.0.1:7447"]);
        let NodeKind::Receiver(follow) = follow.kind else {
            panic!("another kind");
        };
        assert_eq!(
            follow.slaves.len(),
            usize::from(task != FollowerTask::Watch)
        );
        assert_eq!(follow.transport.connect, ["tcp/127.0.0.1:7447"]);
        assert!(coaxle_receiver::Receiver::new(&follow, coaxle_clock::Instant::EPOCH, 1).is_ok());
    }
}

#[test]
fn two_pcs_have_certificates_with_their_addresses() {
    let scratch = tempfile::tempdir().expect("a scratch folder");
    let args = args(
        scratch.path(),
        "line@192.168.1.10",
        "saw@saw.local",
        FollowerTask::Saw,
    );
    let plan = written(&args).expect("a network");
    assert!(plan.is_secure);
    for member in ["line", "saw", OPERATOR, "authority"] {
        let folder = scratch.path().join(NETWORK).join(member);
        assert!(folder.join("ca.pem").exists(), "{member}");
    }
    let text = std::fs::read_to_string(scratch.path().join("saw.toml")).expect("a config");
    for part in [
        "tls/192.168.1.10:7447",
        "tls/0.0.0.0:7448",
        "secure = \"net/saw\"",
        "cycle-time-us = 2000",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
    let next = next(scratch.path(), &plan);
    assert!(
        next.contains("On saw.local, with saw.toml and net/saw, at the same places:"),
        "{next}"
    );
}

#[test]
fn what_is_wrong_is_named() {
    let scratch = tempfile::tempdir().expect("a scratch folder");
    let wrong = |args: &InitArgs| written(args).map(drop).expect_err("wrong").to_string();
    let alike = args(scratch.path(), "saw", "saw", FollowerTask::Gear);
    assert!(wrong(&alike).contains("a name of its own"));
    std::fs::write(scratch.path().join("notes"), "mine").expect("a file");
    let full = args(scratch.path(), "line", "saw", FollowerTask::Gear);
    assert!(wrong(&full).contains("has files in it"));
    for node in ["", "a b", "saw@", "saw@10.0.0.1:7447", "saw@a/b"] {
        assert!(PlacedNode::read(node).is_err(), "{node}");
    }
    assert!(PlacedNode::read("saw@fd00::1").is_ok());
}
