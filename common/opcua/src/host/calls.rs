//! Calls of methods: the client's right, the order, and the response of the node.

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use async_trait::async_trait;
use coaxle_host::client::Commander;
use coaxle_host::network::credentials::{AUTHORITY_FILE, RevocationWatch};
use coaxle_node::CommandOrder;
use coaxle_node::audit::AuditOutcome;
use coaxle_node::command::Addressee;
use coaxle_node::keys::NodeName;
use opcua::core::sync::RwLock;
use opcua::server::address_space::AddressSpace;
use opcua::server::diagnostics::NamespaceMetadata;
use opcua::server::node_manager::memory::InMemoryNodeManagerImpl;
use opcua::server::node_manager::{MethodCall, RequestContext, ServerContext};
use opcua::types::{NodeId, StatusCode, UAString, Variant};
use tokio::sync::Semaphore;

use super::audit::CallAudit;
use crate::config::OpcuaConfig;
use crate::method::{ArgumentValue, CommandMethod, InvalidCall, order_of_json};
use crate::outcome::MethodOutcome;
use crate::rights::{OpcuaClient, RightsConfig};

/// Orders that are on their way at a time; further calls wait.
// Each occupies a thread for some seconds if its node is gone.
const MOST_ORDERS: usize = 16;

/// A method in the address space.
#[derive(Clone)]
pub(super) struct CallTarget {
    pub(super) node: NodeName,
    pub(super) addressee: Addressee,
    /// The command; none for one as JSON.
    pub(super) method: Option<Arc<CommandMethod>>,
}

/// Sends the orders of clients that may command.
pub(super) struct Caller {
    rights: RightsConfig,
    revoked: Option<RevocationWatch>,
    commander: Arc<Commander>,
    audit: CallAudit,
    permits: Semaphore,
}

/// Node manager of the objects of nodes.
pub(super) struct NodeObjects {
    pub(super) namespace: NamespaceMetadata,
    pub(super) targets: RwLock<HashMap<NodeId, CallTarget>>,
    pub(super) caller: Caller,
}

impl Caller {
    pub(super) fn new(config: &OpcuaConfig, commander: Commander) -> Self {
        let beside = |folder: &Path| RevocationWatch::beside(&folder.join(AUTHORITY_FILE));
        Self {
            rights: config.rights.clone(),
            revoked: config.transport.secure.as_deref().map(beside),
            commander: Arc::new(commander),
            audit: CallAudit::new(&config.name),
            permits: Semaphore::new(MOST_ORDERS),
        }
    }

    /// Carries out a call.
    async fn call(&self, context: &RequestContext, target: &CallTarget, call: &mut MethodCall) {
        let (client, issued) = client_of(context);
        let object = format!("{}/{}", target.node, addressee(target));
        let command = target
            .method
            .as_ref()
            .map_or("execute", |method| method.key);
        if let Err(reason) = self.right(&client, issued) {
            self.audit
                .note(&client, command, &object, AuditOutcome::Refused, &reason);
            call.set_status(StatusCode::BadUserAccessDenied);
            return;
        }
        let values: Vec<_> = call.arguments().iter().map(value_of).collect();
        let outcome = match target.order(&values) {
            Ok(order) => self.send(target, order, &client, &object).await,
            Err(InvalidCall::Command(reason)) => MethodOutcome::not_taken(reason),
            Err(InvalidCall::Type(place, reason)) => {
                return refuse(
                    call,
                    place,
                    StatusCode::BadTypeMismatch,
                    &object,
                    command,
                    &reason,
                );
            }
            Err(InvalidCall::Range(place, reason)) => {
                return refuse(
                    call,
                    place,
                    StatusCode::BadOutOfRange,
                    &object,
                    command,
                    &reason,
                );
            }
        };
        call.set_outputs(outputs(&outcome));
        call.set_status(StatusCode::Good);
    }

    async fn send(
        &self,
        target: &CallTarget,
        order: CommandOrder,
        client: &OpcuaClient,
        object: &str,
    ) -> MethodOutcome {
        let (name, is_dry_run) = (order.command_name(), order.is_dry_run());
        // Closed by nobody.
        let _permit = self.permits.acquire().await;
        let (commander, node) = (Arc::clone(&self.commander), target.node.clone());
        // The commander waits for the response: not on a thread that serves clients.
        let sent = tokio::task::spawn_blocking(move || commander.send(&node, &order)).await;
        let outcome = match sent {
            Ok(Ok(answer)) => MethodOutcome::of(&answer),
            Ok(Err(error)) => MethodOutcome::no_response(format!("{error:#}")),
            Err(error) => MethodOutcome::no_response(error.to_string()),
        };
        if !is_dry_run {
            let result = match outcome.outcome {
                "accepted" => AuditOutcome::Accepted,
                "refused" => AuditOutcome::Refused,
                _ => AuditOutcome::NotTaken,
            };
            self.audit.note(client, name, object, result, &outcome.text);
        }
        outcome
    }

    fn right(&self, client: &OpcuaClient, issued: u64) -> Result<(), String> {
        if let (Some(revoked), OpcuaClient::Named(name)) = (&self.revoked, client)
            && revoked.list().revokes(name, issued)
        {
            return Err(format!("the certificate of {name:?} is revoked"));
        }
        self.rights.check(client)
    }
}

impl CallTarget {
    fn order(&self, values: &[ArgumentValue]) -> Result<CommandOrder, InvalidCall> {
        match (&self.method, values) {
            (Some(method), values) => method.order(self.addressee, values),
            (None, [ArgumentValue::Flag(is_dry_run), ArgumentValue::Text(json)]) => {
                order_of_json(self.addressee, json, *is_dry_run)
            }
            (None, [ArgumentValue::Flag(_), ..]) => {
                let reason = "command: received no text, expected one with JSON";
                Err(InvalidCall::Type(1, reason.to_owned()))
            }
            (None, _) => {
                let reason = "dry-run: received something else, expected true or false";
                Err(InvalidCall::Type(0, reason.to_owned()))
            }
        }
    }
}

fn addressee(target: &CallTarget) -> String {
    match target.addressee {
        Addressee::Slave(slave) => slave.as_str().to_owned(),
        Addressee::Far(far) => far.as_str().to_owned(),
    }
}

/// Client of a session, and the beginning of its certificate, s since 1970.
fn client_of(context: &RequestContext) -> (OpcuaClient, u64) {
    let session = context.session().read();
    let Some(certificate) = session.client_certificate() else {
        return (OpcuaClient::Anonymous, 0);
    };
    let from = certificate.not_before().map_or(0, |at| at.timestamp());
    // A certificate without a name is nobody's: no config can name it.
    let name = certificate.common_name().unwrap_or_default();
    // The library has the attribute's name in front.
    let name = name.strip_prefix("CN=").unwrap_or(&name).to_owned();
    (OpcuaClient::Named(name), from.unsigned_abs())
}

fn value_of(value: &Variant) -> ArgumentValue {
    match value {
        Variant::Empty => ArgumentValue::Null,
        Variant::Variant(inner) => value_of(inner),
        Variant::Boolean(flag) => ArgumentValue::Flag(*flag),
        Variant::Double(number) => ArgumentValue::Number(*number),
        Variant::Float(number) => ArgumentValue::Number((*number).into()),
        Variant::SByte(number) => ArgumentValue::Integer((*number).into()),
        Variant::Byte(number) => ArgumentValue::Integer((*number).into()),
        Variant::Int16(number) => ArgumentValue::Integer((*number).into()),
        Variant::UInt16(number) => ArgumentValue::Integer((*number).into()),
        Variant::Int32(number) => ArgumentValue::Integer((*number).into()),
        Variant::UInt32(number) => ArgumentValue::Integer((*number).into()),
        Variant::Int64(number) => ArgumentValue::Integer(*number),
        Variant::UInt64(number) => i64::try_from(*number).map_or_else(
            |_| ArgumentValue::Other(number.to_string()),
            ArgumentValue::Integer,
        ),
        Variant::String(text) if text.is_null() => ArgumentValue::Null,
        Variant::String(text) => ArgumentValue::Text(text.as_ref().to_owned()),
        Variant::Array(_) => ArgumentValue::Other("an array".to_owned()),
        other => ArgumentValue::Other(format!("{:?}", other.type_id())),
    }
}

/// Refuses a call because of one argument.
fn refuse(
    call: &mut MethodCall,
    place: usize,
    status: StatusCode,
    object: &str,
    command: &str,
    reason: &str,
) {
    // A status code has no words: the log has them.
    tracing::warn!("{command} of {object} is refused: {reason}");
    let mut results = vec![StatusCode::Good; call.arguments().len().max(place + 1)];
    results[place] = status;
    call.set_argument_error(results);
}

fn outputs(outcome: &MethodOutcome) -> Vec<Variant> {
    let text = |text: &str| Variant::String(UAString::from(text));
    vec![
        Variant::Boolean(outcome.accepted),
        text(outcome.outcome),
        text(&outcome.text),
        text(&outcome.code),
        Variant::UInt32(outcome.job),
        text(&outcome.response),
    ]
}

#[async_trait]
impl InMemoryNodeManagerImpl for NodeObjects {
    async fn init(&self, _: &mut AddressSpace, _: ServerContext) {
        // Objects come with their nodes.
    }

    fn name(&self) -> &str {
        "nodes"
    }

    fn namespaces(&self) -> Vec<NamespaceMetadata> {
        vec![self.namespace.clone()]
    }

    async fn call(
        &self,
        context: &RequestContext,
        _: &RwLock<AddressSpace>,
        calls: &mut [&mut &mut MethodCall],
    ) -> Result<(), StatusCode> {
        for call in calls {
            let target = self.targets.read().get(call.method_id()).cloned();
            match target {
                Some(target) => self.caller.call(context, &target, call).await,
                None => call.set_status(StatusCode::BadMethodInvalid),
            }
        }
        Ok(())
    }
}
