//! Audit of orders: their origin and their result.

use coaxle_node::audit::{AuditDoor, AuditEntry, AuditOutcome};
use coaxle_node::command::CommandVerdict;
use coaxle_node::keys::NodeName;
use coaxle_node::{CommandAnswer, CommandOrder};

use crate::node::audit::Audit;

/// Notes an order in the audit. A dry run moves no axis and is logged at debug level only.
pub(super) fn log(
    node: &NodeName,
    audit: &Audit,
    by: Option<&NodeName>,
    order: &CommandOrder,
    answer: &CommandAnswer,
) {
    // A dry run changes nothing, and a person who tries values out sends many in a row.
    if order.is_dry_run() {
        tracing::debug!(%node, "{}", line(by, order, answer));
    } else {
        audit.note(entry(by, order, answer));
    }
}

/// Entry about a request that was not read as an order.
pub(super) fn unread(by: Option<&NodeName>, answer: &CommandAnswer) -> AuditEntry {
    with_result(by, "request", &answer.verdict)
}

/// Entry about a request under a key of many nodes.
pub(crate) fn ambiguous(key: &str, answer: &CommandAnswer) -> AuditEntry {
    with_result(None, "request", &answer.verdict).on(key)
}

fn entry(by: Option<&NodeName>, order: &CommandOrder, answer: &CommandAnswer) -> AuditEntry {
    with_result(by, order.command_name(), &answer.verdict).on(order.addressee())
}

fn line(by: Option<&NodeName>, order: &CommandOrder, answer: &CommandAnswer) -> String {
    let entry = entry(by, order, answer);
    let dry_run = if order.is_dry_run() {
        ", a dry run"
    } else {
        ""
    };
    let (client, request, result) = (entry.client(), entry.request(), entry.result());
    format!("{client}: {request}{dry_run}: {result}")
}

fn with_result(by: Option<&NodeName>, action: &str, verdict: &CommandVerdict) -> AuditEntry {
    let (outcome, reason) = match verdict {
        CommandVerdict::Accepted { job, .. } => {
            let job = job.map(|job| format!("job {job}"));
            (AuditOutcome::Accepted, job)
        }
        CommandVerdict::Refused { text, .. } => (AuditOutcome::Refused, Some(text.clone())),
        CommandVerdict::NotTaken { text, .. } => (AuditOutcome::NotTaken, Some(text.clone())),
    };
    // Zenoh without certificates names nobody.
    let by = by.map(NodeName::as_str);
    let entry = AuditEntry::new(AuditDoor::Order, by, action, outcome);
    match reason {
        Some(reason) => entry.because(&reason),
        None => entry,
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
