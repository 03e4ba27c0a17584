//! `time`: the time that the PC has in common with others.

use coaxle_node::config::Wrong;

use super::ReceiverConfig;

impl ReceiverConfig {
    /// Checks that a common time has a timing channel on which it is exchanged.
    pub(super) fn check_common_time(&self) -> Result<(), Wrong> {
        let has_channel =
            self.timing_server.is_some() || self.far.iter().any(|far| far.timing.is_some());
        if self.time.is_none() || has_channel {
            return Ok(());
        }
        let expected = "`timing.connect` of a far node, with the address of its timing server; or `timing-server`";
        Err(Wrong::of("time", "one without a timing channel", expected))
    }
}

#[cfg(test)]
mod tests {
    use crate::config::test_config::config;

    #[test]
    fn it_needs_a_timing_channel() {
        let time = "time.ptp = 'auto'\n";
        let far = "[[far]]\nnode = 'a'\naxes = [1]\n";
        let refused = config(&format!("{time}{far}")).unwrap_err().to_string();
        assert!(
            refused.contains("time: received one without a timing channel"),
            "{refused}"
        );
        let with = config(&format!("{time}{far}timing.connect = '127.0.0.1:7450'"));
        assert!(with.unwrap().time.is_some());
        let served = "timing-server.listen = '127.0.0.1:7450'\n";
        assert!(config(&format!("{time}{served}{far}")).is_ok());
    }
}
