//! The server of OPC UA, on threads of its own.

use std::net::TcpListener;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use anyhow::{Context, anyhow};
use opcua::crypto::SecurityPolicy;
use opcua::server::address_space::AddressSpace;
use opcua::server::diagnostics::NamespaceMetadata;
use opcua::server::node_manager::ServerContext;
use opcua::server::node_manager::memory::{InMemoryNodeManager, InMemoryNodeManagerBuilder};
use opcua::server::{ANONYMOUS_USER_TOKEN_ID, ServerBuilder, ServerHandle, SubscriptionCache};
use opcua::types::MessageSecurityMode;
use tempfile::TempDir;
use tokio::runtime::Runtime;
use tracing::subscriber::{NoSubscriber, with_default};

use super::calls::{Caller, NodeObjects};
use crate::config::{EndpointSecurity, OpcuaConfig};

/// Namespace of the objects.
pub(super) const NAMESPACE: &str = "urn:coaxle:nodes";
/// Bounds of sessions and subscriptions.
const MOST_SESSIONS: usize = 50;
const FASTEST_PUBLISHING_MS: f64 = 50.0;
/// Interval of looking for due publications. Values come twenty times a second.
const POLL_MS: u64 = 20;
/// Time that clients have to leave.
const LEAVE_TIMEOUT: Duration = Duration::from_secs(2);

/// Takes the port of the server.
///
/// # Errors
/// The address and the reason: it is in use, say by another server.
pub(super) fn listen(config: &OpcuaConfig) -> anyhow::Result<TcpListener> {
    let at = config.endpoint.listen;
    let listener = TcpListener::bind(at).with_context(|| {
        format!("endpoint.listen: cannot listen on {at}, expected a port that no other server uses")
    })?;
    listener
        .set_nonblocking(true)
        .context("cannot use the listener")?;
    Ok(listener)
}

/// A running server. Dropping it ends it.
pub(super) struct RunningServer {
    runtime: Option<Runtime>,
    handle: ServerHandle,
    objects: Arc<InMemoryNodeManager<NodeObjects>>,
    namespace: u16,
    url: String,
    /// Folder for the library, where there are no certificates. Dropped last: the server has ended then.
    _scratch: Option<TempDir>,
}

impl RunningServer {
    pub(super) fn start(
        config: &OpcuaConfig,
        listener: TcpListener,
        caller: Caller,
    ) -> anyhow::Result<Self> {
        let runtime = tokio::runtime::Builder::new_multi_thread()
            // Clients wait for nothing but the network: two threads serve all.
            .worker_threads(2)
            .thread_name("opcua")
            .enable_all()
            .build()
            .context("cannot start the threads of the server")?;
        let scratch = match &config.endpoint.certificates {
            None => Some(TempDir::new().context("cannot make a folder for the server")?),
            Some(_) => None,
        };
        let url = url(config);
        let builder = builder(config, &url, scratch.as_ref().map(TempDir::path), caller);
        // The library starts tasks as soon as it is built.
        let within = runtime.enter();
        let built = match scratch {
            // That it has no certificate is no error here.
            Some(_) => with_default(NoSubscriber::default(), || builder.build()),
            None => builder.build(),
        };
        let (server, handle) = built.map_err(|error| anyhow!(error))?;
        let objects = handle.node_managers().get_of_type();
        let namespace = handle.get_namespace_index(NAMESPACE);
        let objects: Arc<InMemoryNodeManager<NodeObjects>> =
            objects.context("the server has no objects")?;
        let namespace = namespace.context("the server has no namespace")?;
        let listener =
            tokio::net::TcpListener::from_std(listener).context("cannot use the listener")?;
        drop(within);
        runtime.spawn(async move {
            if let Err(error) = server.run_with(listener).await {
                tracing::error!("the server has ended: {error}");
            }
        });
        Ok(Self {
            runtime: Some(runtime),
            handle,
            objects,
            namespace,
            url,
            _scratch: scratch,
        })
    }

    /// URL for clients.
    pub(super) fn url(&self) -> String {
        self.url.clone()
    }

    pub(super) const fn namespace(&self) -> u16 {
        self.namespace
    }

    pub(super) fn objects(&self) -> &InMemoryNodeManager<NodeObjects> {
        &self.objects
    }

    pub(super) fn subscriptions(&self) -> &SubscriptionCache {
        self.handle.subscriptions()
    }
}

impl Drop for RunningServer {
    fn drop(&mut self) {
        self.handle.cancel();
        if let Some(runtime) = self.runtime.take() {
            runtime.shutdown_timeout(LEAVE_TIMEOUT);
        }
    }
}

fn url(config: &OpcuaConfig) -> String {
    let endpoint = &config.endpoint;
    format!(
        "opc.tcp://{}:{}/",
        endpoint.advertised_host(),
        endpoint.listen.port()
    )
}

fn builder(
    config: &OpcuaConfig,
    url: &str,
    scratch: Option<&Path>,
    caller: Caller,
) -> ServerBuilder {
    let uri = config.application_uri();
    let endpoint = &config.endpoint;
    let (policy, mode) = match endpoint.security {
        EndpointSecurity::SignAndEncrypt => (
            SecurityPolicy::Basic256Sha256,
            MessageSecurityMode::SignAndEncrypt,
        ),
        EndpointSecurity::None => (SecurityPolicy::None, MessageSecurityMode::None),
    };
    // Without certificates the library wants a folder still.
    let pki = endpoint.certificates.as_deref().or(scratch);
    let mut builder = ServerBuilder::new()
        .application_name(format!("Coaxle {}", config.name))
        .application_uri(&uri)
        .product_uri("urn:coaxle")
        .host(endpoint.advertised_host())
        .port(endpoint.listen.port())
        .pki_dir(pki.unwrap_or(Path::new("")))
        .certificate_path("own/cert.der")
        .private_key_path("private/private.pem")
        .create_sample_keypair(false)
        .trust_client_certs(false)
        .check_cert_time(true)
        .discovery_urls(vec![url.to_owned()])
        .max_sessions(MOST_SESSIONS)
        .subscription_poll_interval_ms(POLL_MS)
        .add_endpoint(
            "coaxle",
            ("/", policy, mode, &[ANONYMOUS_USER_TOKEN_ID] as &[&str]),
        )
        .default_endpoint("coaxle")
        .with_node_manager(InMemoryNodeManagerBuilder::new(
            move |context: ServerContext, space: &mut AddressSpace| {
                objects(&context, space, caller)
            },
        ));
    let subscriptions = &mut builder.limits_mut().subscriptions;
    subscriptions.min_publishing_interval_ms = FASTEST_PUBLISHING_MS;
    subscriptions.min_sampling_interval_ms = FASTEST_PUBLISHING_MS;
    builder
}

fn objects(context: &ServerContext, space: &mut AddressSpace, caller: Caller) -> NodeObjects {
    let index = (context.type_tree.write().namespaces_mut()).add_namespace(NAMESPACE);
    space.add_namespace(NAMESPACE, index);
    NodeObjects {
        namespace: NamespaceMetadata {
            namespace_uri: NAMESPACE.to_owned(),
            namespace_index: index,
            ..NamespaceMetadata::default()
        },
        targets: Default::default(),
        caller,
    }
}
