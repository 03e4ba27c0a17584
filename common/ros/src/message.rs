//! The messages, as bytes: [`JointState`] and [`JointTrajectory`].
//!
//! Sources: `sensor_msgs/msg/JointState.msg` and `trajectory_msgs/msg/JointTrajectory.msg` of ROS 2's common_interfaces, CDR of
//! OMG's DDSI-RTPS, 9.3. Lengths are metres and angles radians (REP 103).

use crate::cdr::{CdrError, CdrReader, CdrWriter};

/// A message type, as named on Zenoh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MessageType {
    /// Name in DDS.
    pub name: &'static str,
    /// The hash of its definition (REP 2016): nodes with another definition receive nothing.
    pub hash: &'static str,
}

/// `sensor_msgs/msg/JointState`.
pub const JOINT_STATE: MessageType = MessageType {
    name: "sensor_msgs::msg::dds_::JointState_",
    hash: "RIHS01_a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e",
};

/// `trajectory_msgs/msg/JointTrajectory`.
pub const JOINT_TRAJECTORY: MessageType = MessageType {
    name: "trajectory_msgs::msg::dds_::JointTrajectory_",
    hash: "RIHS01_179b33eba59d676f6d967ac71fe35e7ca2f64b2f3928f4a018cec115e213796e",
};

/// `builtin_interfaces/msg/Time` and `Duration`: seconds, and nanoseconds that are added to them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Time {
    /// Seconds; of a time since 1970.
    pub sec: i32,
    /// Nanoseconds, below 1 000 000 000 as ROS writes them.
    pub nanosec: u32,
}

/// `sensor_msgs/msg/JointState`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JointState {
    /// Time of the state.
    pub stamp: Time,
    /// Frame id of the header.
    pub frame_id: String,
    /// The joints. Each of the other lists has equal length, or is empty.
    pub name: Vec<String>,
    /// m or rad.
    pub position: Vec<f64>,
    /// m/s or rad/s.
    pub velocity: Vec<f64>,
    /// N or Nm.
    pub effort: Vec<f64>,
}

/// `trajectory_msgs/msg/JointTrajectory`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JointTrajectory {
    /// Start of the trajectory; 0: at once.
    pub stamp: Time,
    /// Frame id of the header.
    pub frame_id: String,
    /// The joints; the values of a point are in their order.
    pub joint_names: Vec<String>,
    /// Points of the trajectory.
    pub points: Vec<JointTrajectoryPoint>,
}

/// `trajectory_msgs/msg/JointTrajectoryPoint`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JointTrajectoryPoint {
    /// m or rad.
    pub positions: Vec<f64>,
    /// m/s or rad/s.
    pub velocities: Vec<f64>,
    /// m/s² or rad/s².
    pub accelerations: Vec<f64>,
    /// N or Nm.
    pub effort: Vec<f64>,
    /// Time after the start of the trajectory.
    pub time_from_start: Time,
}

const NANOS: i64 = 1_000_000_000;

impl Time {
    /// Converts nanoseconds. Times beyond the year 2038 become the last instant before it.
    #[must_use]
    pub fn from_nanos(nanos: i64) -> Self {
        // Euclidean: nanoseconds are added to the seconds, also before 1970.
        let sec = nanos.div_euclid(NANOS);
        let nanosec = nanos.rem_euclid(NANOS) as u32;
        Self {
            sec: sec.clamp(i32::MIN.into(), i32::MAX.into()) as i32,
            nanosec,
        }
    }

    /// Converts to nanoseconds.
    #[must_use]
    pub fn as_nanos(self) -> i64 {
        // Nanoseconds of a second and more are accepted: u32 has room for 4.3 s, and the sum is the same.
        i64::from(self.sec) * NANOS + i64::from(self.nanosec)
    }

    fn read(reader: &mut CdrReader<'_>, field: &str) -> Result<Self, CdrError> {
        let (sec, nanosec) = (reader.i32(field)?, reader.u32(field)?);
        Ok(Self { sec, nanosec })
    }

    fn write(self, writer: &mut CdrWriter) {
        writer.i32(self.sec);
        writer.u32(self.nanosec);
    }
}

impl JointState {
    /// Writes the payload of a sample.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut writer = CdrWriter::new();
        self.stamp.write(&mut writer);
        writer.text(&self.frame_id);
        writer.texts(&self.name);
        // The order of the fields is part of the format; names do not travel.
        for values in [&self.position, &self.velocity, &self.effort] {
            writer.f64s(values);
        }
        writer.finish()
    }

    /// Reads the payload of a sample.
    ///
    /// # Errors
    /// [`CdrError`] with the field.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, CdrError> {
        let mut reader = CdrReader::new(bytes)?;
        let message = Self {
            stamp: Time::read(&mut reader, "header.stamp")?,
            frame_id: reader.text("header.frame_id")?,
            // Struct fields are evaluated in the order written here, which is that of the message.
            name: reader.texts("name")?,
            position: reader.f64s("position")?,
            velocity: reader.f64s("velocity")?,
            effort: reader.f64s("effort")?,
        };
        // Bytes left over are another type with the same beginning.
        reader.finish().map(|()| message)
    }
}

impl JointTrajectory {
    /// Writes the payload of a sample.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut writer = CdrWriter::new();
        self.stamp.write(&mut writer);
        writer.text(&self.frame_id);
        writer.texts(&self.joint_names);
        writer.length(self.points.len());
        for point in &self.points {
            point.write(&mut writer);
        }
        writer.finish()
    }

    /// Reads the payload of a sample.
    ///
    /// # Errors
    /// [`CdrError`] with the field.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, CdrError> {
        let mut reader = CdrReader::new(bytes)?;
        let stamp = Time::read(&mut reader, "header.stamp")?;
        let frame_id = reader.text("header.frame_id")?;
        let joint_names = reader.texts("joint_names")?;
        // Each point has at least this size, so that a forged number of points allocates nothing.
        let length = reader.length("points", JointTrajectoryPoint::LEAST_BYTES)?;
        let point = |k| {
            JointTrajectoryPoint::read(&mut reader)
                .map_err(|error| error.within(&format!("points[{k}]")))
        };
        let points = (0..length).map(point).collect::<Result<_, _>>()?;
        reader.finish()?;
        Ok(Self {
            stamp,
            frame_id,
            joint_names,
            points,
        })
    }
}

impl JointTrajectoryPoint {
    /// Four lengths and a time.
    const LEAST_BYTES: usize = 24;

    fn read(reader: &mut CdrReader<'_>) -> Result<Self, CdrError> {
        Ok(Self {
            positions: reader.f64s("positions")?,
            velocities: reader.f64s("velocities")?,
            accelerations: reader.f64s("accelerations")?,
            effort: reader.f64s("effort")?,
            time_from_start: Time::read(reader, "time_from_start")?,
        })
    }

    fn write(&self, writer: &mut CdrWriter) {
        for values in [
            &self.positions,
            &self.velocities,
            &self.accelerations,
            &self.effort,
        ] {
            writer.f64s(values);
        }
        self.time_from_start.write(writer);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn text() -> impl Strategy<Value = String> {
        "[^\0]{0,12}"
    }

    fn numbers() -> impl Strategy<Value = Vec<f64>> {
        proptest::collection::vec(-1e9..1e9, 0..4)
    }

    fn time() -> impl Strategy<Value = Time> {
        (any::<i32>(), 0..1_000_000_000_u32).prop_map(|(sec, nanosec)| Time { sec, nanosec })
    }

    prop_compose! {
        fn point()(positions in numbers(), velocities in numbers(), accelerations in numbers(), effort in numbers(),
                   time_from_start in time()) -> JointTrajectoryPoint {
            JointTrajectoryPoint { positions, velocities, accelerations, effort, time_from_start }
        }
    }

    proptest! {
        #[test]
        fn a_joint_state_comes_back(stamp in time(), frame_id in text(), name in proptest::collection::vec(text(), 0..4),
                                    position in numbers(), velocity in numbers(), effort in numbers()) {
            let state = JointState { stamp, frame_id, name, position, velocity, effort };
            prop_assert_eq!(JointState::from_bytes(&state.to_bytes()), Ok(state));
        }

        #[test]
        fn a_trajectory_comes_back(stamp in time(), frame_id in text(), joint_names in proptest::collection::vec(text(), 0..4),
                                   points in proptest::collection::vec(point(), 0..4)) {
            let trajectory = JointTrajectory { stamp, frame_id, joint_names, points };
            prop_assert_eq!(JointTrajectory::from_bytes(&trajectory.to_bytes()), Ok(trajectory));
        }

        #[test]
        fn bytes_that_are_cut_or_changed_are_refused_or_read(points in proptest::collection::vec(point(), 0..3), cut in 0..300_usize,
                                                            at in 0..300_usize, value: u8) {
            let names = vec!["saw/carriage".to_owned()];
            let mut bytes = JointTrajectory { joint_names: names, points, ..JointTrajectory::default() }.to_bytes();
            bytes.truncate(cut.max(1));
            let at = at % bytes.len();
            bytes[at] = value;
            if let Ok(read) = JointTrajectory::from_bytes(&bytes) {
                prop_assert!(read.points.len() <= bytes.len());
            }
            let _ = JointState::from_bytes(&bytes);
        }

        #[test]
        fn times_come_back(nanos in i64::from(i32::MIN) * NANOS..i64::from(i32::MAX) * NANOS) {
            prop_assert_eq!(Time::from_nanos(nanos).as_nanos(), nanos);
        }
    }

    #[test]
    fn the_bytes_are_those_of_cdr() {
        let state = JointState {
            stamp: Time { sec: 1, nanosec: 2 },
            name: vec!["ab".to_owned()],
            position: vec![1.5],
            ..JointState::default()
        };
        let expected = [
            &[0, 1, 0, 0][..],
            &[1, 0, 0, 0, 2, 0, 0, 0],
            // An empty text consists of its zero, and three bytes that align the following field.
            &[1, 0, 0, 0, 0, 0, 0, 0],
            &[1, 0, 0, 0, 3, 0, 0, 0, b'a', b'b', 0, 0],
            // The number begins at a multiple of eight; empty lists have no numbers to align.
            &[1, 0, 0, 0],
            &1.5_f64.to_le_bytes(),
            &[0; 8],
        ]
        .concat();
        assert_eq!(state.to_bytes(), expected);
    }

    #[test]
    fn who_writes_high_bytes_first_is_understood() {
        let bytes = [
            &[0, 0, 0, 0][..],
            &[0, 0, 0, 7, 0, 0, 0, 8, 0, 0, 0, 1, 0, 0, 0, 0],
            &[0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0],
        ];
        let mut bytes = bytes.concat();
        bytes.truncate(4 + 16 + 4);
        bytes.extend([0, 0, 0, 1]);
        bytes.extend(2.5_f64.to_be_bytes());
        bytes.extend([0; 8]);
        let state = JointState::from_bytes(&bytes).unwrap();
        assert_eq!((state.stamp.sec, state.stamp.nanosec), (7, 8));
        assert_eq!(state.position, [2.5]);
    }

    #[test]
    fn what_is_wrong_is_named() {
        let told = |bytes: &[u8]| JointTrajectory::from_bytes(bytes).unwrap_err().to_string();
        assert!(told(&[]).starts_with("the header: received [], expected [00, 01, ..]"));
        assert!(told(&[0, 3, 0, 0]).contains("received [00, 03, 00, 00]"));
        let short = [0, 1, 0, 0, 1, 0, 0, 0];
        assert_eq!(told(&short), "header.stamp: received 0 bytes, expected 4");
        let trajectory = JointTrajectory {
            points: vec![JointTrajectoryPoint::default(); 2],
            ..JointTrajectory::default()
        };
        let good = trajectory.to_bytes();
        let cut = &good[..good.len() - 4];
        assert!(told(cut).starts_with("points: received 44 bytes, expected 48"));
        let mut huge = good.clone();
        // The length of the positions of the second point.
        let at = good.len() - 24;
        huge[at..at + 4].fill(0xff);
        assert!(
            told(&huge).starts_with("points[1].positions: received 20 bytes, expected 34359738360")
        );
        let mut long = good;
        long.extend([0; 4]);
        assert_eq!(
            told(&long),
            "received 4 bytes behind the last field, expected at most 3"
        );
        let no_text = [0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 7];
        assert!(told(&no_text).starts_with("header.frame_id: received bytes that are no text"));
    }
}
