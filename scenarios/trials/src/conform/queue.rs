//! Messages of a node on their way from the threads of the transport to the one that judges them.

use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::time::Duration;

use anyhow::bail;
use coaxle_clock::Instant;
use coaxle_host::network::transport::{Declared, Delivery, Transport};
use coaxle_os::Machine;

/// Source of messages for a judge: a key, and how the judge takes what comes under it.
pub(super) enum Source<J> {
    /// Published messages.
    Messages(
        String,
        fn(&mut J, Instant<Machine>, &[u8], Option<Delivery>),
    ),
    /// Appearances and ends of tokens.
    Tokens(String, fn(&mut J, &str, bool)),
}

/// A message to hand to its judge.
type QueuedMessage<J> = Box<dyn FnOnce(&mut J) + Send>;

/// Queue of the messages for a judge.
pub(super) struct MessageQueue<J> {
    received: Receiver<QueuedMessage<J>>,
    _declared: Vec<Declared>,
}

impl<J: 'static> MessageQueue<J> {
    /// Makes a queue for `most` messages. One without room is dropped, and counted as missing.
    ///
    /// # Errors
    /// The transport refuses.
    pub(super) fn new(
        transport: &dyn Transport,
        most: usize,
        sources: impl IntoIterator<Item = Source<J>>,
    ) -> anyhow::Result<Self> {
        let (queue, received) = sync_channel::<QueuedMessage<J>>(most);
        let declare = |source| {
            let queue = queue.clone();
            match source {
                Source::Messages(key, take) => {
                    let on_sample = move |at, bytes: &[u8], delivery| {
                        let bytes = bytes.to_vec();
                        let message = move |judge: &mut J| take(judge, at, &bytes, delivery);
                        let _ = queue.try_send(Box::new(message));
                    };
                    transport.observe(&key, Box::new(on_sample))
                }
                Source::Tokens(key, take) => {
                    let on_change = move |key: &str, is_there| {
                        let key = key.to_owned();
                        let message = move |judge: &mut J| take(judge, &key, is_there);
                        let _ = queue.try_send(Box::new(message));
                    };
                    transport.watch(&key, Box::new(on_change))
                }
            }
        };
        Ok(Self {
            _declared: sources.into_iter().map(declare).collect::<Result<_, _>>()?,
            received,
        })
    }

    /// Hands all waiting messages to the judge.
    pub(super) fn hand_over(&self, judge: &mut J) {
        for message in self.received.try_iter() {
            message(judge);
        }
    }

    /// Hands the next message to the judge, if one comes within this time.
    ///
    /// # Errors
    /// The network is gone.
    pub(super) fn hand_over_next(&self, judge: &mut J, timeout: Duration) -> anyhow::Result<()> {
        match self.received.recv_timeout(timeout) {
            Ok(message) => message(judge),
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => bail!("the network is gone"),
        }
        Ok(())
    }
}
