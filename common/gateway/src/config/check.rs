//! Checks of the fields of a gateway's config against each other.

use coaxle_node::config::Wrong;

use super::{GatewayConfig, MOST_AXES, OutputAxisConfig, PlcAxisConfig};

pub(super) fn check(config: &GatewayConfig) -> Result<(), Wrong> {
    // First, since the other checks depend on the kind of connection.
    check_connections(config)?;
    if config.axes.is_empty() && config.outputs.is_empty() {
        let received = "no `axis` and no `output`";
        return Err(Wrong::value(received, "at least one of them"));
    }
    check_lists(config)?;
    if config.ads.is_some() {
        check_symbols(config)?;
    } else {
        check_no_symbols(config)?;
    }
    check_udp(config)
}

fn check_connections(config: &GatewayConfig) -> Result<(), Wrong> {
    let all = [
        ("`ads`", config.ads.is_some()),
        ("`udp`", config.udp.is_some()),
        ("`pipe`", config.pipe.is_some()),
    ];
    let received: Vec<_> = all.iter().filter(|(_, is)| *is).map(|(n, _)| *n).collect();
    let received = match &received[..] {
        [_] => return Ok(()),
        [] => "no way to the PLC".to_owned(),
        several => several.join(" and "),
    };
    Err(Wrong::value(received, "one of `ads`, `udp` and `pipe`"))
}

fn check_lists(config: &GatewayConfig) -> Result<(), Wrong> {
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
        let expected = "one without `ads`: a record has one cycle index";
        return Err(Wrong::of("output", received, expected));
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

fn count(field: &str, received: usize, least: usize) -> Result<(), Wrong> {
    if (least..=MOST_AXES).contains(&received) {
        return Ok(());
    }
    let expected = format!("1 to {MOST_AXES}");
    Err(Wrong::of(field, format_args!("{received} axes"), expected))
}

fn once(field: &str, what: &'static str, all: impl Iterator<Item = String>) -> Result<(), Wrong> {
    let mut seen = std::collections::BTreeSet::new();
    for (number, received) in all.enumerate() {
        if !seen.insert(received.clone()) {
            let field = format!("{field}[{number}].{what}");
            return Err(Wrong::of(
                field,
                format_args!("{received} twice"),
                "each once",
            ));
        }
    }
    Ok(())
}

fn check_symbols(config: &GatewayConfig) -> Result<(), Wrong> {
    let is_empty = |symbol: &Option<String>| symbol.as_ref().is_none_or(String::is_empty);
    let missing = |field: String| {
        let expected = "the symbol of a variable of the PLC, such as \"GVL_Coaxle.stConveyor\"";
        Wrong::of(field, "nothing", expected)
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

fn check_no_symbols(config: &GatewayConfig) -> Result<(), Wrong> {
    // A symbol is refused without ADS, since it would look as if it were used.
    let of_axes = config.axes.iter().position(|axis| axis.symbol.is_some());
    let of_axes = of_axes.map(|number| format!("axis[{number}].symbol"));
    let of_outputs = output_axis(config, |axis| axis.symbol.is_some());
    let of_outputs = of_outputs.map(|axis| format!("{axis}.symbol"));
    let mut outputs = config.outputs.iter();
    let index = outputs.position(|output| output.cycle_index.is_some());
    let index = index.map(|number| format!("output[{number}].cycle-index"));
    match of_axes.or(of_outputs).or(index) {
        Some(field) => Err(Wrong::of(field, "a symbol", "none without `ads`")),
        None => Ok(()),
    }
}

fn check_udp(config: &GatewayConfig) -> Result<(), Wrong> {
    let Some(udp) = &config.udp else {
        return Ok(());
    };
    let ends = [
        ("udp.listen", &udp.listen, !config.axes.is_empty()),
        ("udp.send-to", &udp.send_to, !config.outputs.is_empty()),
    ];
    for (field, end, is_needed) in ends {
        let received = match end {
            None if is_needed => "nothing",
            // Datagrams of a PLC have no usual port, unlike ADS.
            Some(end) if end.port().is_none() => "no port",
            _ => continue,
        };
        let expected = "host:port, such as \"192.168.1.20:5066\"";
        return Err(Wrong::of(field, received, expected));
    }
    Ok(())
}
