//! Files that people write: cam plates, flying saws and flying gears as TOML, and point tables of other programs.
//!
//! | file | read as | format |
//! |--|--|--|
//! | cam plate | [`cam::CamFile`] | `docs/CAMS.md` |
//! | flying saw | [`saw::SawFile`] | `docs/SAWS.md` |
//! | flying gear | [`gear::GearFile`] | `docs/GEARS.md` |
//! | points as CSV or Structured Text | [`point_table::PointTable`] | `docs/CAMS.md` |
//!
//! Configs of nodes are in [`coaxle_node::config`]; errors name file, line, field, the value received and the one
//! expected, as theirs do.

pub mod cam;
pub mod gear;
pub mod point_table;
pub mod saw;
