//! By standard input and output: a PLC that is a program at both ends of a pipe.

use std::io::{BufRead, BufReader, Read, Write};
use std::process::{ChildStdin, ChildStdout, Stdio};
use std::sync::mpsc::{Receiver, Sender, channel};

use coaxle_axis::{ImageLayout, NcToPlcAxis, StateWord};
use coaxle_clock::{Instant, Span};
use coaxle_gateway::config::ImageKind;
use coaxle_gateway::record::{read_record, record_len, write_image};
use coaxle_os::{Machine, machine};
use coaxle_test_process::{Process, assert_alive, until};
use coaxle_tests::ports::free_port;

use crate::gateway::{command, node};

/// The machine may be very busy.
const TIMEOUT: Span = Span::from_secs(120);
const CYCLE: Span = Span::from_millis(4);
/// Distance of the axis per cycle.
const STEP: f64 = 2.0;

#[test]
fn lines_of_csv_go_in_and_come_back_corrected_and_a_broken_one_does_no_harm() {
    let mut pipe = Pipe::start("csv");
    pipe.put(b"index,conveyor.position,conveyor.velocity,conveyor.acceleration\n");
    let mut head = None;
    until("a head line comes", || {
        head = pipe.from_gateway.try_recv().ok();
        head.is_some()
    });
    let expected = "index,saw.1.position,saw.1.velocity,saw.1.acceleration";
    assert_eq!(head, Some(GatewayOutput::Head(expected.to_owned())));
    pipe.turn_until_it_is_close(line);
    // No number, and too few columns.
    pipe.put(b"here,is,no,number\n1,2\n");
    pipe.turn_until_it_is_close(line);
    let log = pipe.end();
    let broken = "index: received \"here\", expected the cycle index, a whole number of at least 0";
    // The first broken line is logged, further ones of its kind are counted.
    assert_eq!(log.matches("standard input, line ").count(), 1, "{log}");
    assert!(log.contains(broken), "{log}");
}

#[test]
fn records_of_bytes_go_in_and_come_back_corrected() {
    let mut pipe = Pipe::start("binary");
    pipe.turn_until_it_is_close(record);
    let log = pipe.end();
    assert!(!log.contains("panicked"), "{log}");
}

/// A gateway with a pipe to it, and a receiver that corrects its axis.
struct Pipe {
    gateway: Process,
    to_gateway: Option<ChildStdin>,
    from_gateway: Receiver<GatewayOutput>,
    count: u64,
    next: Instant<Machine>,
    _receiver: Process,
    _folder: tempfile::TempDir,
}

/// Output of the gateway.
#[derive(Debug, PartialEq)]
enum GatewayOutput {
    Head(String),
    Position(f64),
}

impl Pipe {
    fn start(format: &str) -> Self {
        let (folder, port) = (tempfile::tempdir().expect("a scratch folder"), free_port());
        let config = format!(
            "name = 'plc'\ncycle-time-us = 4000\n[pipe]\nformat = '{format}'\n\
             [transport]\nlisten = ['tcp/127.0.0.1:{port}']\n\
             [[axis]]\nid = 1\nname = 'conveyor'\n\
             [[output]]\nnode = 'saw'\n[[output.axis]]\nid = 1\n"
        );
        let receiver = format!(
            "name = 'saw'\ncycle-time-us = 4000\npublish-far-axes = true\n\
             [transport]\nconnect = ['tcp/127.0.0.1:{port}']\n\
             [[far]]\nnode = 'plc'\naxes = [1]\n"
        );
        let mut gateway = command("gateway", folder.path(), &config);
        gateway.stdin(Stdio::piped()).stdout(Stdio::piped());
        let log = folder.path().join("gateway.log");
        let gateway = Process::start("gateway", &mut gateway, &log);
        let (output, from_gateway) = channel();
        let out = gateway.take_stdout().expect("a pipe");
        let is_csv = format == "csv";
        // Beside the test: a gateway whose pipe is full stands still.
        std::thread::spawn(move || {
            if is_csv {
                lines(out, &output)
            } else {
                records(out, &output)
            }
        });
        Self {
            to_gateway: gateway.take_stdin(),
            gateway,
            from_gateway,
            count: 0,
            next: machine::now(),
            _receiver: node("receiver", folder.path(), &receiver),
            _folder: folder,
        }
    }

    fn put(&mut self, bytes: &[u8]) {
        let pipe = self.to_gateway.as_mut().expect("it is open");
        pipe.write_all(bytes)
            .and_then(|()| pipe.flush())
            .expect("it is read");
    }

    /// Runs cycles until half of the newest hundred that came back are within ten cycles: the receiver has locked in.
    fn turn_until_it_is_close(&mut self, form: fn(u64) -> Vec<u8>) {
        let until = machine::now() + TIMEOUT;
        loop {
            let mut behind = Vec::new();
            while behind.len() < 100 {
                assert_alive("the axis comes back");
                assert!(machine::now() < until, "{} came", behind.len());
                self.next = self.next.max(machine::now() - Span::from_millis(50)) + CYCLE;
                machine::sleep_until(self.next);
                self.count += 1;
                self.put(&form(self.count));
                let here = STEP * self.count as f64;
                behind.extend(
                    self.from_gateway
                        .try_iter()
                        .filter_map(|output| match output {
                            GatewayOutput::Position(position) => {
                                Some((here - position).abs() / STEP)
                            }
                            GatewayOutput::Head(_) => None,
                        }),
                );
            }
            behind.sort_by(f64::total_cmp);
            let median = behind[behind.len() / 2];
            // 40 ms.
            if median < 10.0 {
                println!("a pipe: half of them within {median:.3} cycles");
                return;
            }
            assert!(machine::now() < until, "{median} cycles behind");
        }
    }

    /// Ends standard input, which the gateway logs, and goes on. Returns the log until then.
    fn end(&mut self) -> String {
        drop(self.to_gateway.take());
        until("the gateway says that standard input has ended", || {
            self.gateway.logged("standard input has ended")
        });
        assert_alive("the gateway goes on");
        self.gateway.log()
    }
}

fn line(count: u64) -> Vec<u8> {
    let position = STEP * count as f64;
    let velocity = STEP / CYCLE.as_secs_f64();
    // The index wraps as a PLC's does.
    format!("{},{position},{velocity},0\n", count as u16).into_bytes()
}

fn record(count: u64) -> Vec<u8> {
    let axis = NcToPlcAxis {
        state_word: StateWord::OPERATIONAL | StateWord::HOMED,
        set_position: STEP * count as f64,
        set_velocity: STEP / CYCLE.as_secs_f64(),
        ..NcToPlcAxis::default()
    };
    let mut record = (count as u16).to_le_bytes().to_vec();
    write_image(ImageKind::NcToPlc, ImageLayout::AxisRef, &axis, &mut record);
    record
}

/// A field is empty until the receiver knows the axis.
fn lines(out: ChildStdout, output: &Sender<GatewayOutput>) {
    for (number, line) in BufReader::new(out)
        .lines()
        .map_while(Result::ok)
        .enumerate()
    {
        let position = line.split(',').nth(1).and_then(|cell| cell.parse().ok());
        let what = match position {
            _ if number == 0 => GatewayOutput::Head(line),
            Some(position) => GatewayOutput::Position(position),
            None => continue,
        };
        if output.send(what).is_err() {
            return;
        }
    }
}

fn records(mut out: ChildStdout, output: &Sender<GatewayOutput>) {
    let mut bytes = vec![0; record_len(1)];
    let mut axes = [NcToPlcAxis::default()];
    while out.read_exact(&mut bytes).is_ok() {
        read_record(ImageLayout::AxisRef, &bytes, &mut axes).expect("its length is right");
        if output
            .send(GatewayOutput::Position(axes[0].set_position))
            .is_err()
        {
            return;
        }
    }
}
