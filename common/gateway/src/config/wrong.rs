//! Fields of a gateway's config that do not fit each other.

use super::{GatewayConfig, MOST_AXES, OutputAxisConfig, PlcAxisConfig};

/// Fields that do not fit each other. The field is named first.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum WrongGateway {
    /// No connection to the PLC, or several.
    #[error("received {}, expected one of `ads`, `udp` and `pipe`", connections(.received))]
    Connections {
        /// Connections received.
        received: Vec<&'static str>,
    },
    /// Neither axes nor an output.
    #[error("received no `axis` and no `output`, expected at least one of them")]
    Nothing,
    /// More axes than a frame holds, or none where one is required.
    #[error("{field}: received {received} axes, expected 1 to {MOST_AXES}")]
    Count {
        /// The list.
        field: String,
        /// Number of axes.
        received: usize,
    },
    /// A value shared by two axes.
    #[error("{field}[{number}].{what}: received {received} twice, expected each once")]
    Duplicate {
        /// The list.
        field: String,
        /// The number of the second one.
        number: usize,
        /// Kind of the shared value.
        what: &'static str,
        /// Value received.
        received: String,
    },
    /// A missing field that this connection to the PLC requires.
    #[error("{field}: received nothing, expected {expected}")]
    Missing {
        /// The field.
        field: String,
        /// Value expected.
        expected: &'static str,
    },
    /// A field that this connection to the PLC does not use.
    #[error("{field}: received a symbol, expected none without `ads`")]
    Symbol {
        /// The field.
        field: String,
    },
    /// Several outputs where a record has one cycle index.
    #[error(
        "output: received {received}, expected one without `ads`: a record has one cycle index"
    )]
    Outputs {
        /// Number of outputs.
        received: usize,
    },
    /// An address without a port.
    #[error("{field}: received no port, expected host:port, such as \"192.168.1.20:5066\"")]
    Port {
        /// The field.
        field: &'static str,
    },
}

fn connections(received: &[&str]) -> String {
    match received {
        [] => "no way to the PLC".to_owned(),
        some => some
            .iter()
            .map(|way| format!("`{way}`"))
            .collect::<Vec<_>>()
            .join(" and "),
    }
}

pub(super) fn check(config: &GatewayConfig) -> Result<(), WrongGateway> {
    // First, since the other checks depend on the kind of connection.
    check_connections(config)?;
    if config.axes.is_empty() && config.outputs.is_empty() {
        return Err(WrongGateway::Nothing);
    }
    check_lists(config)?;
    if config.ads.is_some() {
        check_symbols(config)?;
    } else {
        check_no_symbols(config)?;
    }
    check_udp(config)
}

fn check_connections(config: &GatewayConfig) -> Result<(), WrongGateway> {
    let all = [
        ("ads", config.ads.is_some()),
        ("udp", config.udp.is_some()),
        ("pipe", config.pipe.is_some()),
    ];
    let received: Vec<_> = all.iter().filter(|(_, is)| *is).map(|(n, _)| *n).collect();
    match received.len() {
        1 => Ok(()),
        _ => Err(WrongGateway::Connections { received }),
    }
}

fn check_lists(config: &GatewayConfig) -> Result<(), WrongGateway> {
    // Axes of the PLC are optional: a gateway may only write to it.
    count("axis", config.axes.len(), 0)?;
    let ids = config.axes.iter().map(|axis| axis.id.to_string());
    once("axis", "id", ids)?;
    let names = config
        .axes
        .iter()
        .map(|axis| format!("{:?}", axis.name.as_str()));
    once("axis", "name", names)?;
    let received = config.outputs.len();
    // A record on a pipe or in a datagram has one index, which belongs to one node's cycle.
    if received > 1 && config.ads.is_none() {
        return Err(WrongGateway::Outputs { received });
    }
    let outputs = config.outputs.iter();
    let sources =
        // A node may stand in several outputs with different channels.
        outputs.map(|output| format!("{:?} of {:?}", output.channel, output.node.as_str()));
    once("output", "node", sources)?;
    for (number, output) in config.outputs.iter().enumerate() {
        let field = format!("output[{number}].axis");
        count(&field, output.axes.len(), 1)?;
        let ids = output.axes.iter().map(|axis| axis.id.to_string());
        once(&field, "id", ids)?;
    }
    Ok(())
}

fn count(field: &str, received: usize, least: usize) -> Result<(), WrongGateway> {
    if (least..=MOST_AXES).contains(&received) {
        return Ok(());
    }
    let field = field.to_owned();
    Err(WrongGateway::Count { field, received })
}

fn once(
    field: &str,
    what: &'static str,
    all: impl Iterator<Item = String>,
) -> Result<(), WrongGateway> {
    let mut seen = std::collections::BTreeSet::new();
    for (number, received) in all.enumerate() {
        if !seen.insert(received.clone()) {
            return Err(WrongGateway::Duplicate {
                field: field.to_owned(),
                number,
                what,
                received,
            });
        }
    }
    Ok(())
}

fn check_symbols(config: &GatewayConfig) -> Result<(), WrongGateway> {
    let is_empty = |symbol: &Option<String>| symbol.as_ref().is_none_or(String::is_empty);
    let missing = |field: String| WrongGateway::Missing {
        field,
        expected: "the symbol of a variable of the PLC, such as \"GVL_Coaxle.stConveyor\"",
    };
    let lacks = |axis: &PlcAxisConfig| is_empty(&axis.symbol);
    if let Some(number) = config.axes.iter().position(lacks) {
        return Err(missing(format!("axis[{number}].symbol")));
    }
    let index = config.ads.as_ref().and_then(|ads| ads.cycle_index.clone());
    // Without axes the index is read by nobody.
    if !config.axes.is_empty() && is_empty(&index) {
        return Err(missing("ads.cycle-index".to_owned()));
    }
    match output_axis(config, |axis| is_empty(&axis.symbol)) {
        Some(axis) => Err(missing(format!("{axis}.symbol"))),
        None => Ok(()),
    }
}

/// Returns the path of the first axis of an output that fulfils the condition.
fn output_axis(
    config: &GatewayConfig,
    is_it: impl Fn(&OutputAxisConfig) -> bool,
) -> Option<String> {
    let mut outputs = config.outputs.iter().enumerate();
    outputs.find_map(|(number, output)| {
        let axis = output.axes.iter().position(&is_it)?;
        Some(format!("output[{number}].axis[{axis}]"))
    })
}

fn check_no_symbols(config: &GatewayConfig) -> Result<(), WrongGateway> {
    // A symbol is refused without ADS, since it would look as if it were used.
    let of_axes = config.axes.iter().position(|axis| axis.symbol.is_some());
    let of_axes = of_axes.map(|number| format!("axis[{number}].symbol"));
    let of_outputs = output_axis(config, |axis| axis.symbol.is_some());
    let of_outputs = of_outputs.map(|axis| format!("{axis}.symbol"));
    let mut outputs = config.outputs.iter();
    let index = outputs.position(|output| output.cycle_index.is_some());
    let index = index.map(|number| format!("output[{number}].cycle-index"));
    match of_axes.or(of_outputs).or(index) {
        Some(field) => Err(WrongGateway::Symbol { field }),
        None => Ok(()),
    }
}

fn check_udp(config: &GatewayConfig) -> Result<(), WrongGateway> {
    let Some(udp) = &config.udp else {
        return Ok(());
    };
    let ends = [
        ("udp.listen", &udp.listen, !config.axes.is_empty()),
        ("udp.send-to", &udp.send_to, !config.outputs.is_empty()),
    ];
    for (field, end, is_needed) in ends {
        match end {
            None if is_needed => {
                return Err(WrongGateway::Missing {
                    field: field.to_owned(),
                    expected: "host:port, such as \"192.168.1.20:5066\"",
                });
            }
            // Datagrams of a PLC have no usual port, unlike ADS.
            Some(end) if end.port().is_none() => return Err(WrongGateway::Port { field }),
            _ => {}
        }
    }
    Ok(())
}
