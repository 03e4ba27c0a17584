//! Orders about cam plates on the command line, and their responses in words.

use std::path::PathBuf;
use std::sync::LazyLock;

use clap::error::ErrorKind;
use clap::{Arg, ArgAction, ArgMatches, Command, value_parser};
use coaxle_files::cam::CamFile;
use coaxle_node::command::{CamFigures, PlateCommand, PlateOrder};
use coaxle_report::inspect::shown;
use serde_json::{Map, Value, json};

use super::blocks::{Block, blocks_of};
use super::options::{fields_of, subcommand};

const SELECT: &str = "cam-table-select";

/// Every command about a plate but `cam-table-select`, whose plate comes from a file.
static BLOCKS: LazyLock<Vec<Block>> = LazyLock::new(|| {
    let mut blocks = blocks_of::<PlateCommand>();
    blocks.retain(|block| block.name != SELECT);
    blocks
});

/// Every cam order with its options.
pub(super) fn subcommands() -> impl Iterator<Item = Command> {
    let select = Command::new(SELECT)
        .about("MC_CamTableSelect: load a plate from a cam file, or put it in the place of another")
        .arg(
            Arg::new("file")
                .required(true)
                .value_name("FILE")
                .value_parser(value_parser!(PathBuf))
                .help("Cam file, TOML; it is sent whole, with the CSV file that it may name"),
        )
        .arg(
            Arg::new("table")
                .long("table")
                .value_parser(value_parser!(u8).range(1..))
                .help("Id of the plate; that of the file by default"),
        )
        .arg(
            Arg::new("replace")
                .long("replace")
                .action(ArgAction::SetTrue)
                .help("It may take the place of a plate of that id"),
        );
    [select].into_iter().chain(BLOCKS.iter().map(subcommand))
}

/// The fields that the options set.
pub(super) fn fields(name: &str, options: &ArgMatches) -> Result<Value, clap::Error> {
    if name == SELECT {
        return select(options);
    }
    Ok(fields_of(&BLOCKS, name, options))
}

fn select(options: &ArgMatches) -> Result<Value, clap::Error> {
    let refused = |text: String| clap::Error::raw(ErrorKind::ValueValidation, format!("{text}\n"));
    let Some(file) = options.get_one::<PathBuf>("file") else {
        return Err(clap::Error::new(ErrorKind::MissingRequiredArgument));
    };
    let cam = CamFile::load(file).map_err(|error| refused(error.to_string()))?;
    // A file that makes no plate is reported with its line, and need not be sent.
    cam.plate().map_err(|error| refused(error.to_string()))?;
    let id = cam.table_id.map(|id| u32::from(id.get()));
    let plate = serde_json::to_value(PlateOrder::new(cam.source(), id));
    let mut fields = Map::new();
    if let Some(table) = options.get_one::<u8>("table") {
        fields.insert("table".to_owned(), json!(table));
    }
    if options.get_flag("replace") {
        fields.insert("replace".to_owned(), json!(true));
    }
    let plate = plate.map_err(|error| refused(format!("{}: {error}", file.display())))?;
    fields.insert("plate".to_owned(), plate);
    Ok(Value::Object(fields))
}

/// The figures read, in a line or as a table.
pub(super) fn read(figures: &CamFigures) -> String {
    match figures {
        CamFigures::Points {
            number_of_rows,
            points,
        } => {
            let lines = points.iter().map(|point| {
                let law = point.law.map_or("", |law| law.file_name());
                let kind = point.point_type.map_or("", |kind| kind.file_name());
                format!(
                    "\n{}  {}  {}  {law}  {kind}",
                    point.index.unwrap_or_default(),
                    shown(point.master),
                    shown(point.slave)
                )
            });
            format!(
                "; {} of {number_of_rows} points: number, master, slave, law, type{}",
                points.len(),
                lines.collect::<String>()
            )
        }
        CamFigures::Values { columns, rows } => {
            let lines = rows.iter().map(|row| {
                let cells: Vec<String> = row.iter().map(|value| shown(*value)).collect();
                format!("\n{}", cells.join("  "))
            });
            format!(
                "; {} rows: {}{}",
                rows.len(),
                columns.join(", "),
                lines.collect::<String>()
            )
        }
        CamFigures::SlaveDynamics {
            position,
            velocity,
            acceleration,
        } => format!(
            "; on the plate the slave is at {}, velocity {}, acceleration {}",
            shown(*position),
            shown(*velocity),
            shown(*acceleration)
        ),
        CamFigures::Characteristics(found) => {
            let values = found.values.iter();
            let lines = values.map(|named| format!("\n{} {}", named.name, shown(named.value)));
            let steps = match found.largest_velocity_step {
                None => String::new(),
                Some(step) => format!(
                    "\nvelocity steps at {} places, the largest at master {}: from {} to {}",
                    found.velocity_steps,
                    shown(step.master),
                    shown(step.before),
                    shown(step.after)
                ),
            };
            format!(
                "; {} rows, lift {}{}{steps}",
                found.number_of_rows,
                shown(found.lift),
                lines.collect::<String>()
            )
        }
        CamFigures::MasterPosition { low, high } => {
            let side = |found: &Option<_>| found.as_ref().map_or_else(|| "none".to_owned(), at);
            format!("; the master below: {}, above: {}", side(low), side(high))
        }
        CamFigures::Info(info) => format!(
            "; plate {}: master {} on it, slave {} on it, offsets {} and {}, scalings {} and {}; --json has all of it",
            info.table,
            shown(info.master_cam_position),
            shown(info.slave_cam_position),
            shown(info.master_offset),
            shown(info.slave_offset),
            shown(info.master_scaling),
            shown(info.slave_scaling)
        ),
    }
}

fn at(found: &coaxle_node::command::MasterFigures) -> String {
    format!(
        "{} ({} on the plate, slave offset {})",
        shown(found.master_axis_position),
        shown(found.master_cam_position),
        shown(found.slave_offset)
    )
}
