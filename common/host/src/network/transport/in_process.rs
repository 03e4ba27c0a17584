//! A transport within one process: for tests, and for nodes that share it.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use coaxle_clock::Instant;
use coaxle_os::machine::{self, Machine};

use super::{
    BytesHandler, Client, Declared, PresenceHandler, Publisher, Request, RequestHandler, Transport,
    Urgency,
};

/// Joins all holders of a clone of it. Published data are delivered at once, on the publishing
/// thread, without loss.
#[derive(Clone)]
pub struct InProcess {
    hub: Arc<Mutex<Hub>>,
    /// Clock for the arrival stamps.
    now: Arc<dyn Fn() -> Instant<Machine> + Send + Sync>,
}

#[derive(Default)]
struct Hub {
    declared: u64,
    subscribers: Handlers<Mutex<BytesHandler>>,
    announcements: Handlers<()>,
    watchers: Handlers<PresenceHandler>,
    servers: Handlers<RequestHandler>,
}

/// Handlers by key and declaration number.
type Handlers<H> = BTreeMap<(String, u64), Arc<H>>;

impl Default for InProcess {
    fn default() -> Self {
        Self::dated_by(machine::now)
    }
}

impl InProcess {
    /// Creates a transport that stamps arrivals by another clock than the machine's.
    pub fn dated_by(now: impl Fn() -> Instant<Machine> + Send + Sync + 'static) -> Self {
        Self {
            hub: Arc::default(),
            now: Arc::new(now),
        }
    }

    fn hub(&self) -> MutexGuard<'_, Hub> {
        // A panic in a handler of a test must not poison all others: the maps are whole between statements.
        self.hub.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds a handler until the result is dropped.
    fn declare<H: Send + Sync + 'static>(
        &self,
        key: &str,
        handler: H,
        place: fn(&mut Hub) -> &mut Handlers<H>,
    ) -> Held<H> {
        let mut hub = self.hub();
        hub.declared += 1;
        // Numbered: two declarations of one key live and end apart.
        let at = (key.to_owned(), hub.declared);
        place(&mut hub).insert(at.clone(), Arc::new(handler));
        Held {
            transport: self.clone(),
            at,
            place,
        }
    }

    /// The handlers of a key and of all patterns that match it, so that they can be called without
    /// the hub.
    fn all_meant<H>(&self, key: &str, place: fn(&mut Hub) -> &mut Handlers<H>) -> Vec<Arc<H>> {
        // Cloned out of the lock: a handler may publish, subscribe or drop a declaration itself.
        let mut hub = self.hub();
        let meant = place(&mut hub).iter().filter(|((of, _), _)| means(of, key));
        meant.map(|(_, handler)| Arc::clone(handler)).collect()
    }

    fn is_announced(&self, key: &str) -> bool {
        !self.all_meant(key, |hub| &mut hub.announcements).is_empty()
    }

    fn tell_watchers(&self, key: &str, is_there: bool) {
        for on_change in self.all_meant(key, |hub| &mut hub.watchers) {
            on_change(key, is_there);
        }
    }

    /// Announced keys that match a key.
    fn announced(&self, key: &str) -> Vec<String> {
        let hub = self.hub();
        let announced = hub.announcements.keys().map(|(key, _)| key.clone());
        // The other way round: here the argument is the pattern, and the announcements are keys.
        announced
            .filter(|announced| means(key, announced))
            .collect()
    }
}

/// True if a pattern matches a key: equal parts, or `*` in the pattern.
fn means(pattern: &str, key: &str) -> bool {
    let (mut wanted, mut parts) = (pattern.split('/'), key.split('/'));
    loop {
        // Part by part: `*` stands for exactly one part, and a longer key does not match.
        match (wanted.next(), parts.next()) {
            (None, None) => return true,
            (Some(wanted), Some(part)) if wanted == "*" || wanted == part => {}
            _ => return false,
        }
    }
}

/// A handler with its place in the hub.
struct Held<H> {
    transport: InProcess,
    at: (String, u64),
    place: fn(&mut Hub) -> &mut Handlers<H>,
}

impl<H> Drop for Held<H> {
    fn drop(&mut self) {
        let handler = (self.place)(&mut self.transport.hub()).remove(&self.at);
        // Dropped without the hub lock: the handler may hold declarations of the hub too.
        drop(handler);
    }
}

/// An announcement; watchers are notified of its end.
struct Announced(Option<Held<()>>);

impl Drop for Announced {
    fn drop(&mut self) {
        let Some(held) = self.0.take() else {
            return;
        };
        let (transport, (key, _)) = (held.transport.clone(), held.at.clone());
        // Removed before the question: the own announcement would otherwise still count.
        drop(held);
        // A second announcement of the same key is still there: watchers see one presence, as in Zenoh.
        if !transport.is_announced(&key) {
            transport.tell_watchers(&key, false);
        }
    }
}

impl Transport for InProcess {
    fn publisher(&self, key: &str, _urgency: Urgency) -> anyhow::Result<Box<dyn Publisher>> {
        Ok(Box::new(ToKey {
            transport: self.clone(),
            key: key.to_owned(),
        }))
    }

    fn subscribe(&self, key: &str, on_bytes: BytesHandler) -> anyhow::Result<Declared> {
        Ok(Box::new(self.declare(key, Mutex::new(on_bytes), |hub| {
            &mut hub.subscribers
        })))
    }

    fn announce(&self, key: &str) -> anyhow::Result<Declared> {
        // Asked before declaring, for the same reason as at the end.
        let is_first = !self.is_announced(key);
        let held = self.declare(key, (), |hub| &mut hub.announcements);
        if is_first {
            self.tell_watchers(key, true);
        }
        Ok(Box::new(Announced(Some(held))))
    }

    fn watch(&self, key: &str, on_change: PresenceHandler) -> anyhow::Result<Declared> {
        // Announcements that exist already are reported first, as Zenoh's history does.
        for announced in self.announced(key) {
            on_change(&announced, true);
        }
        Ok(Box::new(
            self.declare(key, on_change, |hub| &mut hub.watchers),
        ))
    }

    fn serve(&self, key: &str, on_request: RequestHandler) -> anyhow::Result<Declared> {
        Ok(Box::new(
            self.declare(key, on_request, |hub| &mut hub.servers),
        ))
    }

    fn client(&self, key: &str, patience: Duration) -> anyhow::Result<Box<dyn Client>> {
        let to = ToKey {
            transport: self.clone(),
            key: key.to_owned(),
        };
        Ok(Box::new(Requests { to, patience }))
    }

    fn whereabouts(&self) -> &str {
        "within this process"
    }

    fn close(&self) {}
}

/// Publisher for one key.
struct ToKey {
    transport: InProcess,
    key: String,
}

impl Publisher for ToKey {
    fn publish(&self, bytes: Vec<u8>) -> anyhow::Result<()> {
        // Taken once: all subscribers of a sample see the same arrival.
        let arrival = (self.transport.now)();
        for on_bytes in self
            .transport
            .all_meant(&self.key, |hub| &mut hub.subscribers)
        {
            // A subscriber is called by one thread at a time, as a callback of Zenoh is.
            let mut on_bytes = on_bytes.lock().unwrap_or_else(PoisonError::into_inner);
            on_bytes(arrival, &bytes);
        }
        Ok(())
    }

    fn has_subscriber(&self) -> bool {
        !self
            .transport
            .all_meant(&self.key, |hub| &mut hub.subscribers)
            .is_empty()
    }
}

/// Client for one key.
struct Requests {
    to: ToKey,
    patience: Duration,
}

impl Client for Requests {
    fn has_server(&self) -> bool {
        let ToKey { transport, key } = &self.to;
        !transport.all_meant(key, |hub| &mut hub.servers).is_empty()
    }

    fn request(&self, json: String) -> anyhow::Result<Option<Vec<u8>>> {
        let ToKey { transport, key } = &self.to;
        let (reply, replies) = channel();
        for on_request in transport.all_meant(key, |hub| &mut hub.servers) {
            let request = InProcessRequest {
                key: key.clone(),
                json: json.clone(),
                reply: reply.clone(),
            };
            on_request((transport.now)(), Box::new(request));
        }
        // Only the requests keep the reply channel open.
        drop(reply);
        Ok(replies.recv_timeout(self.patience).ok())
    }
}

/// A request within the process.
struct InProcessRequest {
    key: String,
    json: String,
    reply: Sender<Vec<u8>>,
}

impl Request for InProcessRequest {
    fn key(&self) -> &str {
        &self.key
    }

    fn payload(&self) -> Cow<'_, [u8]> {
        self.json.as_bytes().into()
    }

    fn reply(&self, json: String, _taken: bool) {
        // The client may be gone.
        let _ = self.reply.send(json.into_bytes());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    type Seen<T> = Arc<Mutex<Vec<T>>>;
    type Arrived = (Instant<Machine>, Vec<u8>);

    fn at(nanos: i64) -> Instant<Machine> {
        Instant::from_nanos(nanos)
    }

    fn subscribed(transport: &InProcess, key: &str) -> (Declared, Seen<Arrived>) {
        let seen: Seen<_> = Arc::default();
        let kept = Arc::clone(&seen);
        let on_bytes = move |at, bytes: &[u8]| kept.lock().unwrap().push((at, bytes.to_vec()));
        (transport.subscribe(key, Box::new(on_bytes)).unwrap(), seen)
    }

    #[test]
    fn what_is_published_reaches_all_who_subscribe_to_its_key_while_they_do() {
        let transport = InProcess::dated_by(|| at(7));
        let publisher = transport.publisher("a", Urgency::RealTime).unwrap();
        // Published without any subscriber: the value is lost, not kept.
        assert!(!publisher.has_subscriber());
        publisher.publish(vec![0]).unwrap();
        let (first, seen_first) = subscribed(&transport, "a");
        let (_second, seen_second) = subscribed(&transport, "a");
        let (_other, seen_other) = subscribed(&transport, "b");
        publisher.publish(vec![1]).unwrap();
        drop(first);
        publisher.publish(vec![2]).unwrap();
        assert!(publisher.has_subscriber());
        assert_eq!(*seen_first.lock().unwrap(), [(at(7), vec![1])]);
        assert_eq!(
            *seen_second.lock().unwrap(),
            [(at(7), vec![1]), (at(7), vec![2])]
        );
        assert!(seen_other.lock().unwrap().is_empty());
    }

    #[test]
    fn who_watches_hears_of_the_first_announcement_and_of_the_end_of_the_last() {
        let transport = InProcess::default();
        let seen: Seen<bool> = Arc::default();
        let watch = || {
            let kept = Arc::clone(&seen);
            let on_change = move |_: &str, there| kept.lock().unwrap().push(there);
            transport.watch("a", Box::new(on_change)).unwrap()
        };
        let early = watch();
        let (one, two) = (
            transport.announce("a").unwrap(),
            transport.announce("a").unwrap(),
        );
        drop((one, transport.announce("b").unwrap()));
        // `b` appears and ends without a word, and `one` ends while `two` is still there.
        assert_eq!(*seen.lock().unwrap(), [true]);
        drop(two);
        assert_eq!(*seen.lock().unwrap(), [true, false]);
        drop(early);
        let _three = transport.announce("a").unwrap();
        assert_eq!(seen.lock().unwrap().len(), 2);
        let _late = watch();
        assert_eq!(*seen.lock().unwrap(), [true, false, true]);
    }

    #[test]
    fn a_request_gets_the_reply_of_who_serves_its_key() {
        let transport = InProcess::dated_by(|| at(3));
        let client = transport.client("a", Duration::from_secs(9)).unwrap();
        let ask = |text: &str| client.request(text.to_owned()).unwrap();
        assert!(!client.has_server());
        // Nobody holds the reply channel, so that the nine seconds are not waited for.
        assert_eq!(ask("nobody"), None);
        let on_request = |at: Instant<Machine>, request: Box<dyn Request>| {
            if *request.payload() != *b"ignored" {
                let text = String::from_utf8(request.payload().to_vec()).unwrap();
                request.reply(format!("{} {text} {}", request.key(), at.as_nanos()), true);
            }
        };
        let served = transport.serve("a", Box::new(on_request)).unwrap();
        assert!(client.has_server());
        assert_eq!(ask("hello").unwrap(), b"a hello 3");
        // Dropped without a reply: the request ends at once.
        assert_eq!(ask("ignored"), None);
        drop(served);
        assert_eq!(ask("hello"), None);
    }

    #[test]
    fn who_serves_a_pattern_is_told_the_key_that_was_asked() {
        let transport = InProcess::default();
        let on_request = |_, request: Box<dyn Request>| request.reply(request.key().into(), true);
        let _served = transport.serve("a/*", Box::new(on_request)).unwrap();
        let client = transport.client("a/b", Duration::from_secs(9)).unwrap();
        assert!(client.has_server());
        assert_eq!(client.request(String::new()).unwrap().unwrap(), b"a/b");
        for other in ["a", "c/b"] {
            let client = transport.client(other, Duration::ZERO).unwrap();
            assert!(!client.has_server(), "{other}");
        }
    }
}
