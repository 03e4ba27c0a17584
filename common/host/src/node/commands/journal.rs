//! Log lines of orders: their origin and their result.

use coaxle_node::command::CommandVerdict;
use coaxle_node::keys::NodeName;
use coaxle_node::{CommandAnswer, CommandOrder};

/// Logs an order that reached the cycle. A dry run moves no axis and is logged at debug level only.
pub(super) fn log(
    node: &NodeName,
    by: Option<&NodeName>,
    order: &CommandOrder,
    answer: &CommandAnswer,
) {
    let line = line(by, order, answer);
    match order.is_dry_run() {
        // A dry run changes nothing, and a person who tries values out sends many in a row.
        true => tracing::debug!(%node, "{line}"),
        false => tracing::info!(%node, "{line}"),
    }
}

fn line(by: Option<&NodeName>, order: &CommandOrder, answer: &CommandAnswer) -> String {
    let by = match by {
        // Zenoh without certificates names nobody.
        Some(name) => format!("{:?}", name.as_str()),
        None => "somebody without a name".to_owned(),
    };
    let dry_run = if order.is_dry_run() {
        ", a dry run"
    } else {
        ""
    };
    format!(
        "order of {by}: {} to {:?}{dry_run}: {}",
        order.command_name(),
        order.addressee(),
        outcome(&answer.verdict)
    )
}

fn outcome(verdict: &CommandVerdict) -> String {
    match verdict {
        CommandVerdict::Accepted { job: Some(job), .. } => format!("accepted, job {job}"),
        CommandVerdict::Accepted { job: None, .. } => "accepted".to_owned(),
        CommandVerdict::Refused { text, .. } => format!("refused, {text}"),
        CommandVerdict::NotTaken { text, .. } => format!("not taken, {text}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use coaxle_node::command::{SlaveName, SlaveOrder};
    use coaxle_slave::Command;

    #[test]
    fn who_gave_it_is_named() {
        let mut order = SlaveOrder {
            addressee: SlaveName::new("carriage").unwrap(),
            command: Command::Power(true),
            dry_run: false,
        };
        let said = |by, order: SlaveOrder| {
            let order = CommandOrder::from(order);
            line(
                by,
                &order,
                &CommandAnswer::new(&order, &order.without_addressee()),
            )
        };
        let anna = NodeName::new("anna").unwrap();
        assert_eq!(
            said(Some(&anna), order),
            "order of \"anna\": MC_Power to \"carriage\": not taken, the node has no slaves"
        );
        order.dry_run = true;
        assert_eq!(
            said(None, order),
            "order of somebody without a name: MC_Power to \"carriage\", a dry run: not taken, the node has \
             no slaves"
        );
    }
}
