//! Good inputs: shipped files, examples of the documents, and messages of nodes.

use std::path::{Path, PathBuf};

use coaxle_axis::NcToPlcAxis;
use coaxle_clock::{CycleIndex, CycleTime, Instant, Span};
use coaxle_curve::profile::Limits;
use coaxle_files::cam::CamFile;
use coaxle_files::point_table::PointTable;
use coaxle_node::exchange::{
    MAX_TIME_RESPONSES, ReceivedRequest, TIME_REQUEST_CAPACITY, TIME_RESPONSES_CAPACITY,
    TimeResponsesHeader, encode_time_request, encode_time_responses,
};
use coaxle_node::followers::{REPORTS_CAPACITY, encode_reports};
use coaxle_node::frame::{KeySeal, body_capacity, encode_body, seal, sender_id};
use coaxle_node::plan::{PLANS_CAPACITY, encode_plans};
use coaxle_node::{
    AxisPlan, Channel, FollowerReport, FollowerState, FrameHeader, PresentAfter, RunCycle,
    TimeRequest,
};
use coaxle_source::{AxisSource, MotionProgram};

use crate::streams::subscription_to;
use crate::wire::{FOLLOWED, far, near};

type Seeds = Vec<(String, Vec<u8>)>;

/// The folder of the workspace.
#[must_use]
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The files of a folder with this ending, in the order of their names.
pub(crate) fn shipped(folder: &str, ending: &str) -> Seeds {
    let folder = root().join(folder);
    let entries = std::fs::read_dir(&folder).expect("a folder of the workspace");
    let mut paths: Vec<_> = entries
        .map(|entry| entry.expect("an entry").path())
        .collect();
    paths.retain(|path| path.extension().is_some_and(|found| found == ending));
    paths.sort();
    // A renamed folder must not leave a target without seeds.
    assert!(!paths.is_empty(), "{}: no .{ending}", folder.display());
    let named = |path: &PathBuf| {
        let name = path
            .file_stem()
            .expect("a name")
            .to_string_lossy()
            .into_owned();
        (name, std::fs::read(path).expect("a shipped file"))
    };
    paths.iter().map(named).collect()
}

/// The CSV files of tables, which are positions alone.
pub(crate) fn cam_tables() -> Seeds {
    let mut tables = shipped("scenarios/cams", "csv");
    tables.retain(|(name, _)| name.ends_with("table"));
    tables
}

/// The points of the shipped cam files as CSV.
pub(crate) fn point_tables() -> Seeds {
    tables(PointTable::to_csv)
}

/// The points of the shipped cam files as arrays of a PLC.
pub(crate) fn plc_arrays() -> Seeds {
    tables(|table| table.to_structured_text("Cam"))
}

fn tables(text: impl Fn(&PointTable) -> String) -> Seeds {
    let written = |(name, _): (String, Vec<u8>)| {
        let path = root().join("scenarios/cams").join(format!("{name}.toml"));
        let cam = CamFile::load(&path).expect("a shipped file");
        (name, text(&PointTable::from(&cam.source())).into_bytes())
    };
    let shipped = shipped("scenarios/cams", "toml");
    shipped.into_iter().map(written).collect()
}

pub(crate) fn scenarios() -> Seeds {
    let mut all = shipped("scenarios/catalog", "toml");
    all.extend(shipped("scenarios/catalog/faults", "toml"));
    all
}

/// The examples of `docs/WIRE.md`, which has one of every command.
pub(crate) fn orders() -> Seeds {
    let document = std::fs::read_to_string(root().join("docs/WIRE.md")).expect("the document");
    let (far, slave) = document
        .split_once("### What a slave can be told")
        .expect("the section");
    let orders = |part: &str, addressee: &str, name: &str| {
        let rows = part.lines().filter(|line| line.starts_with("| `{ \""));
        let command = |row: &str| row.split('`').nth(1).expect("a command").to_owned();
        let order = |(n, row): (usize, &str)| {
            let command = command(row);
            let order = format!(
                "{{ \"version\": 1, \"{addressee}\": \"{name}\", \"command\": {command} }}"
            );
            (format!("{addressee}-{n}"), order.into_bytes())
        };
        rows.enumerate().map(order).collect::<Vec<_>>()
    };
    let mut all = orders(far, "far", "conveyor");
    all.extend(orders(slave, "slave", "carriage"));
    // A table of another form would silently have no rows.
    assert!(all.len() > 30, "{}", all.len());
    all
}

pub(crate) fn recordings() -> Seeds {
    let named = |(name, text): (&str, &str)| (name.to_owned(), text.as_bytes().to_vec());
    [
        ("positions", "time_s,position\n0,0\n0.5,1\n1,4\n1.5,9\n"),
        (
            "velocities",
            "time_s,position,velocity\n-1,0,0\n0,1,2\n2,5,2\n",
        ),
        (
            "all",
            "time_s, position, velocity, acceleration\n0,0,0,1\n1e0,0.5,1,1\n2,2,2,0\n",
        ),
    ]
    .map(named)
    .into()
}

fn header(count: u64) -> FrameHeader {
    FrameHeader {
        sender: sender_id(&far()),
        epoch: 5,
        index: CycleIndex::of_count(count),
        count,
        cycle_time: cycle_time(),
        present_after: None,
        send_stamp: None,
    }
}

fn cycle_time() -> CycleTime {
    CycleTime::new(Span::from_millis(1)).expect("a cycle time")
}

/// A frame of these axes, all 0.3 u further in each cycle.
fn frame(count: u64, ids: &[u32], stamp: Option<Span>) -> Vec<u8> {
    frame_of(&header(count), ids, stamp)
}

/// Such a frame, to be shown 8 ms later.
fn presented(count: u64, ids: &[u32], stamp: Option<Span>) -> Vec<u8> {
    let header = FrameHeader {
        present_after: PresentAfter::new(Span::from_millis(8)),
        ..header(count)
    };
    frame_of(&header, ids, stamp)
}

fn frame_of(header: &FrameHeader, ids: &[u32], stamp: Option<Span>) -> Vec<u8> {
    let axis = |id: &u32| NcToPlcAxis {
        axis_id: *id,
        set_position: 0.3 * header.count as f64,
        set_velocity: 300.0,
        ..NcToPlcAxis::default()
    };
    let axes: Vec<_> = ids.iter().map(axis).collect();
    let mut body = vec![0; body_capacity(axes.len())];
    let length = encode_body(header, &axes, &mut body).expect("the body has room");
    sealed(Channel::Axes, &body[..length], stamp)
}

fn sealed(channel: Channel, body: &[u8], stamp: Option<Span>) -> Vec<u8> {
    let node = if channel == Channel::TimeRequests {
        near()
    } else {
        far()
    };
    let mut frame = Vec::new();
    KeySeal::new(&node.channel_key(channel)).seal(body, stamp, &mut frame);
    frame
}

pub(crate) fn frames() -> Seeds {
    let late = Some(Span::from_micros(37));
    vec![
        ("three-axes".to_owned(), frame(0, &FOLLOWED, late)),
        // Beyond 65 535, where count and index differ.
        ("without-stamp".to_owned(), frame(70_000, &[1], None)),
        ("more-axes".to_owned(), frame(9, &[7, 8, 9, 1, 2, 3], late)),
        ("an-axis-twice".to_owned(), frame(9, &[1, 1, 2], late)),
        ("presented".to_owned(), presented(9, &FOLLOWED, late)),
    ]
}

pub(crate) fn time_requests() -> Seeds {
    let request = |number, start| {
        let mut body = [0; TIME_REQUEST_CAPACITY];
        let length = encode_time_request(
            sender_id(&far()),
            5,
            number,
            Instant::from_nanos(start),
            &mut body,
        );
        sealed(
            Channel::TimeRequests,
            &body[..length],
            Some(Span::from_micros(12)),
        )
    };
    vec![
        ("first".to_owned(), request(0, 0)),
        ("later".to_owned(), request(u32::MAX, i64::MAX)),
    ]
}

pub(crate) fn time_responses() -> Seeds {
    let responses = |count: usize| {
        let header = TimeResponsesHeader {
            sender: sender_id(&far()),
            epoch: 5,
            count: 40,
            cycle_time: cycle_time(),
        };
        let reply = ReceivedRequest {
            request: TimeRequest {
                requester: sender_id(&near()),
                run: 1,
                number: 0,
                requested: 1_000_000,
            },
            received: Span::from_millis(39),
        };
        let mut body = [0; TIME_RESPONSES_CAPACITY];
        let length = encode_time_responses(&header, &vec![reply; count], &mut body);
        sealed(
            Channel::TimeResponses,
            &body[..length],
            Some(Span::from_micros(12)),
        )
    };
    vec![
        ("one".to_owned(), responses(1)),
        ("as-many-as-fit".to_owned(), responses(MAX_TIME_RESPONSES)),
        ("none".to_owned(), responses(0)),
    ]
}

/// Plans of a program, from its start and in a move.
pub(crate) fn plans() -> Seeds {
    let program = "limits = { velocity = 1000, acceleration = 5000, jerk = 100000 }\nsteps = [{ enable = true }, \
                   { dwell = { for-s = 0.1 } }, { move-absolute = { position = 300 } }]";
    let program = coaxle_node::config::parse("p.toml", program).expect("a program");
    let mut axis = MotionProgram::new(&program).with_lead(Span::from_millis(400));
    let mut message = |millis: i64, ids: &[u32]| {
        let now = Span::from_millis(millis);
        axis.sample(now);
        let plan = axis.plan(now, Span::ZERO).expect("a plan");
        let plans: Vec<_> = (ids.iter())
            .map(|id| AxisPlan { axis_id: *id, plan })
            .collect();
        let header = RunCycle {
            sender: sender_id(&far()),
            epoch: 5,
            count: millis as u64,
        };
        let mut body = [0; PLANS_CAPACITY];
        let length = encode_plans(&header, &plans, &mut body);
        sealed(Channel::Plans, &body[..length], Some(Span::from_micros(12)))
    };
    vec![
        ("standing".to_owned(), message(0, &FOLLOWED)),
        ("moving".to_owned(), message(150, &[2, 9])),
        ("none".to_owned(), message(200, &[])),
    ]
}

/// Reports of a follower.
pub(crate) fn reports() -> Seeds {
    let message = |reports: u32, node| {
        let report = |axis_id| FollowerReport {
            node,
            run: 5,
            axis_id,
            state: FollowerState {
                slaves: 3,
                in_sync: 2,
                in_error: 1,
                distance: 0.001,
                limits: Limits::NONE,
                wanted_delay: None,
            },
        };
        let reports: Vec<_> = (0..reports).map(report).collect();
        let header = RunCycle {
            sender: sender_id(&near()),
            epoch: 8,
            count: 1_000,
        };
        let mut body = [0; REPORTS_CAPACITY];
        let length = encode_reports(&header, &reports, &mut body);
        let mut message = Vec::new();
        let key = near().channel_key(Channel::Followers);
        seal(
            &key,
            &body[..length],
            Some(Span::from_micros(12)),
            &mut message,
        );
        message
    };
    let far = sender_id(&far());
    vec![
        ("one".to_owned(), message(1, far)),
        ("as-many-as-fit".to_owned(), message(16, far)),
        ("of-another-node".to_owned(), message(2, 1)),
        ("none".to_owned(), message(0, far)),
    ]
}

/// Streams of messages as `arrivals` takes them.
pub(crate) fn arrivals() -> Seeds {
    let mut steady = Vec::new();
    for count in 0..60 {
        let stamp = Some(Span::from_micros(5));
        push(&mut steady, Channel::Axes, &frame(count, &FOLLOWED, stamp));
    }
    let mut exchanging = Vec::new();
    for count in 0..30 {
        push(
            &mut exchanging,
            Channel::Axes,
            &frame(count, &FOLLOWED, None),
        );
        let (_, response) = &time_responses()[0];
        push(&mut exchanging, Channel::TimeResponses, response);
        let (_, request) = &time_requests()[0];
        push(&mut exchanging, Channel::TimeRequests, request);
    }
    let mut later = Vec::new();
    for count in 0..60 {
        let stamp = Some(Span::from_micros(5));
        push(
            &mut later,
            Channel::Axes,
            &presented(count, &FOLLOWED, stamp),
        );
    }
    vec![
        ("steady".to_owned(), steady),
        ("exchanging".to_owned(), exchanging),
        ("presented".to_owned(), later),
    ]
}

/// Appends a message a millisecond after the one before, with its check sum corrected.
fn push(stream: &mut Vec<u8>, channel: Channel, message: &[u8]) {
    // In units of 100 µs: frames come a cycle apart, the rest with them.
    let later = if channel == Channel::Axes { 10 } else { 0 };
    stream.extend_from_slice(&[0x80 | subscription_to(channel), later]);
    let length = u16::try_from(message.len()).expect("a short message");
    stream.extend_from_slice(&length.to_le_bytes());
    stream.extend_from_slice(message);
}
