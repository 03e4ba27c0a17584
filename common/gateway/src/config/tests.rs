use super::*;
use coaxle_node::config::parse;

const HEAD: &str = "name = 'press'\ncycle-time-us = 1000\n";
const ADS: &str = "[ads]\naddress = '10.0.0.2'\nnet-id = '10.0.0.2.1.1'\ncycle-index = 'G.n'\n";
const AXIS: &str = "[[axis]]\nid = 1\nname = 'belt'\nsymbol = 'G.a'\n";
const OUTPUT: &str = "[[output]]\nnode = 'saw'\n[[output.axis]]\nid = 1\nsymbol = 'G.c'\n";

fn read(text: &str) -> Result<GatewayConfig, String> {
    let config: GatewayConfig =
        parse("g.toml", &format!("{HEAD}{text}")).map_err(|error| error.to_string())?;
    config.check().map_err(|wrong| wrong.to_string())?;
    Ok(config)
}

#[test]
fn what_is_left_out_has_its_default() {
    let config = read(&format!("{ADS}{AXIS}{OUTPUT}")).unwrap();
    let ads = config.ads.as_ref().unwrap();
    assert_eq!((ads.port, ads.read), (851, ReadMode::Polling));
    assert_eq!(config.layout, Layout::AxisRef);
    // Half of the 1000 µs.
    assert_eq!(config.poll_period(), Span::from_micros(500));
    assert_eq!(config.scan_time().span(), Span::from_micros(500));
    let output = &config.outputs[0];
    assert_eq!(output.channel, OutputChannel::FarAxes);
    assert_eq!(output.axes[0].image, ImageKind::NcToPlc);
    // Time requests, and the one output.
    assert_eq!(config.wiring().subscriptions.len(), 2);
}

#[test]
fn a_config_survives_being_written_and_read() {
    let config = read(&format!("{ADS}own-net-id = '10.0.0.1.1.1'\n{AXIS}{OUTPUT}")).unwrap();
    let text = toml_of(&config);
    assert_eq!(parse::<GatewayConfig>("again.toml", &text).unwrap(), config);
}

fn toml_of(config: &GatewayConfig) -> String {
    toml::to_string(config).unwrap()
}

#[test]
fn errors_name_the_field_what_came_and_what_is_expected() {
    let udp = "[udp]\nlisten = '127.0.0.1:5066'\nsend-to = '127.0.0.1:5067'\n";
    let bare = AXIS.replace("symbol = 'G.a'\n", "");
    for (text, expected) in [
        (
            AXIS.to_owned(),
            "received no way to the PLC, expected one of `ads`, `udp` and `pipe`",
        ),
        (
            format!("{ADS}[pipe]\n{AXIS}"),
            "received `ads` and `pipe`, expected one of `ads`, `udp` and `pipe`",
        ),
        (
            ADS.to_owned(),
            "received no `axis` and no `output`, expected at least one of them",
        ),
        (
            format!("{ADS}{AXIS}{AXIS}"),
            "axis[1].id: received 1 twice, expected each once",
        ),
        (
            format!("{ADS}{bare}"),
            "axis[0].symbol: received nothing, expected the symbol of a variable",
        ),
        (
            format!("{}{AXIS}", ADS.replace("cycle-index = 'G.n'\n", "")),
            "ads.cycle-index: received nothing",
        ),
        (
            format!("{udp}{AXIS}"),
            "axis[0].symbol: received a symbol, expected none without `ads`",
        ),
        (
            format!("[udp]\n{bare}"),
            "udp.listen: received nothing, expected host:port",
        ),
        (
            format!("[udp]\nlisten = 'here'\n{bare}"),
            "udp.listen: received no port",
        ),
        (
            format!("{ADS}[[output]]\nnode = 'saw'\naxis = []\n"),
            "output[0].axis: received 0 axes, expected 1 to 128",
        ),
        (
            format!("{ADS}{}", OUTPUT.replace("[[output]]", "[output]")),
            "g.toml:7:1: output: received one table [output], expected a list: [[output]]",
        ),
        (
            format!("{ADS}{OUTPUT}{OUTPUT}"),
            "output[1].node: received FarAxes of \"saw\" twice, expected each once",
        ),
        (
            format!("[pipe]\n{0}{0}", OUTPUT.replace("symbol = 'G.c'\n", "")),
            "output: received 2, expected one without `ads`: a record has one cycle index",
        ),
        (
            format!("{ADS}{OUTPUT}[[output]]\nnode = 'knife'\n[[output.axis]]\nid = 2\n"),
            "output[1].axis[0].symbol: received nothing, expected the symbol of a variable",
        ),
        (
            format!("{}{AXIS}", ADS.replace("10.0.0.2.1.1", "10.0.0.2")),
            "g.toml:5:10: ads.net-id: received \"10.0.0.2\", expected six numbers",
        ),
        // A host cannot have a blank.
        (
            format!("{}{AXIS}", ADS.replace("'10.0.0.2'", "'a b'")),
            "g.toml:4:11: ads.address: received \"a b\", expected a host or host:port",
        ),
        (
            format!("{ADS}pol-us = 3\n{AXIS}"),
            "g.toml:7:1: ads.pol-us: unknown field",
        ),
    ] {
        let message = read(&text).unwrap_err();
        assert!(message.starts_with(expected), "{text}\n{message}");
    }
}
