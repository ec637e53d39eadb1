//! Channels, clients and what waits for them. Nothing here waits: a client that is slow loses its oldest messages, and
//! no other notices.

use serde::Serialize;
use sextant_proto::SiteId;
use sextant_queue::{DropRule, Queue, StreamBounds};
use sextant_recordings::foxglove::ViewerMessage;
use sextant_recordings::foxglove::schema::Schema;
use sextant_recordings::foxglove::websocket::{
    AdvertisedChannel, ClientRequest, Subscription, advertise, message_data, server_info,
};
use std::collections::{BTreeMap, VecDeque};
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use tokio::sync::Notify;

/// Most clients that are served at once.
pub const MAX_CLIENTS: usize = 16;
/// Most channels: some for each camera and object of a site.
const MAX_CHANNELS: usize = 8192;
/// Most messages that wait for a client, and their bytes.
const WAITING: StreamBounds = StreamBounds::new(1024, 16 << 20);
/// Most bytes of messages that are kept for later clients.
const MAX_KEPT_BYTES: usize = 32 << 20;

/// How long a message is of interest.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Lifetime {
    /// For clients that are there.
    Passing,
    /// For later ones too, until the next on its topic.
    UntilReplaced,
}

/// A message for a client.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Frame {
    Text(String),
    Binary(Vec<u8>),
}

/// The number of a client.
pub type ClientId = u64;

/// What clients are offered and get.
#[derive(Debug)]
pub struct Hub {
    name: String,
    session: String,
    state: Mutex<HubState>,
    n_clients: AtomicUsize,
    invalid: AtomicU64,
}

#[derive(Debug, Default)]
struct HubState {
    channels: BTreeMap<String, Channel>,
    kept_bytes: usize,
    clients: BTreeMap<ClientId, Client>,
    counts: HubCounts,
}

/// Counts of clients and frames since the start.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct HubCounts {
    /// Clients that were served.
    pub clients: u64,
    /// Messages handed to connections.
    pub sent: u64,
    /// Messages that clients were too slow for.
    pub dropped: u64,
    /// Payloads of the site that were no message.
    pub invalid: u64,
    /// Connections that were no viewer's, or one too many.
    pub turned_away: u64,
}

#[derive(Debug)]
struct Channel {
    id: u32,
    schema: fn() -> Schema,
    kept: Option<Kept>,
}

#[derive(Debug)]
struct Kept {
    log_ns: u64,
    data: Vec<u8>,
}

#[derive(Debug)]
struct Client {
    /// The client's numbers by those of channels.
    subscriptions: BTreeMap<u32, u32>,
    texts: VecDeque<String>,
    data: Queue<Vec<u8>>,
    ready: Arc<Notify>,
}

impl Hub {
    /// A hub without channels.
    pub fn new(site: &SiteId) -> Self {
        Self {
            name: format!("Sextant {site}"),
            session: sextant_process::now_ns().to_string(),
            state: Mutex::default(),
            n_clients: AtomicUsize::new(0),
            invalid: AtomicU64::new(0),
        }
    }

    /// Whether anybody is there.
    pub fn is_watched(&self) -> bool {
        self.n_clients.load(Ordering::Relaxed) > 0
    }

    /// Counts a payload that was no message.
    pub fn count_invalid(&self) {
        self.invalid.fetch_add(1, Ordering::Relaxed);
    }

    /// Counts of clients and frames since the start.
    pub fn counts(&self) -> HubCounts {
        HubCounts {
            invalid: self.invalid.load(Ordering::Relaxed),
            ..self.lock().counts
        }
    }

    /// Sends a message to those who have subscribed to its topic.
    pub fn publish(&self, message: &ViewerMessage, log_ns: u64, lifetime: Lifetime) {
        let mut state = self.lock();
        let Some(channel) = state.channel_of(message) else {
            return;
        };
        if lifetime == Lifetime::UntilReplaced {
            state.keep(message, log_ns);
        }
        let HubState {
            clients, counts, ..
        } = &mut *state;
        for client in clients.values_mut() {
            if let Some(subscription) = client.subscriptions.get(&channel) {
                let frame = message_data(*subscription, log_ns, &message.data);
                counts.dropped += client.push(frame);
            }
        }
    }

    /// A new client, unless there are too many.
    pub fn join(&self) -> Option<(ClientId, Arc<Notify>)> {
        let mut state = self.lock();
        if state.clients.len() >= MAX_CLIENTS {
            return None;
        }
        let mut client = Client::new();
        client.say(server_info(&self.name, &self.session));
        client.say(advertise(
            state
                .channels
                .iter()
                .map(|(topic, it)| advertised(topic, it)),
        ));
        let ready = Arc::clone(&client.ready);
        state.counts.clients += 1;
        let id = state.counts.clients;
        state.clients.insert(id, client);
        self.n_clients.store(state.clients.len(), Ordering::Relaxed);
        Some((id, ready))
    }

    /// A client has left.
    pub fn leave(&self, id: ClientId) {
        let mut state = self.lock();
        state.clients.remove(&id);
        self.n_clients.store(state.clients.len(), Ordering::Relaxed);
    }

    /// A connection was turned away; whether it is one of the first, which are reported.
    pub fn turn_away(&self) -> bool {
        const REPORTED: u64 = 10;
        let mut state = self.lock();
        state.counts.turned_away += 1;
        state.counts.turned_away <= REPORTED
    }

    /// A client has said something.
    pub fn request(&self, id: ClientId, text: &str) {
        let Some(request) = ClientRequest::parse(text) else {
            return;
        };
        let mut state = self.lock();
        match request {
            ClientRequest::Subscribe { subscriptions } => {
                subscriptions
                    .iter()
                    .for_each(|one| state.subscribe(id, *one));
            }
            ClientRequest::Unsubscribe { subscription_ids } => {
                if let Some(client) = state.clients.get_mut(&id) {
                    let is_kept = |_: &u32, id: &mut u32| !subscription_ids.contains(id);
                    client.subscriptions.retain(is_kept);
                }
            }
            ClientRequest::Other => {}
        }
    }

    /// The next frame for a client. Texts go first: they are what binary ones refer to.
    pub fn next_frame(&self, id: ClientId) -> Option<Frame> {
        let mut state = self.lock();
        let frame = state.clients.get_mut(&id)?.pop()?;
        state.counts.sent += u64::from(matches!(frame, Frame::Binary(_)));
        Some(frame)
    }

    fn lock(&self) -> MutexGuard<'_, HubState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn advertised<'a>(topic: &'a str, channel: &Channel) -> AdvertisedChannel<'a> {
    AdvertisedChannel {
        id: channel.id,
        topic,
        schema: channel.schema,
    }
}

impl HubState {
    /// The channel of a message; a new one is offered to all clients.
    fn channel_of(&mut self, message: &ViewerMessage) -> Option<u32> {
        if let Some(channel) = self.channels.get(&message.topic) {
            return Some(channel.id);
        }
        if self.channels.len() >= MAX_CHANNELS {
            return None;
        }
        let channel = Channel {
            id: self.channels.len() as u32 + 1,
            schema: message.schema,
            kept: None,
        };
        let offer = advertise([advertised(&message.topic, &channel)]);
        for client in self.clients.values_mut() {
            client.say(offer.clone());
        }
        let id = channel.id;
        self.channels.insert(message.topic.clone(), channel);
        Some(id)
    }

    fn keep(&mut self, message: &ViewerMessage, log_ns: u64) {
        let Some(channel) = self.channels.get_mut(&message.topic) else {
            return;
        };
        let before = channel.kept.take().map_or(0, |kept| kept.data.len());
        self.kept_bytes -= before;
        if self.kept_bytes + message.data.len() <= MAX_KEPT_BYTES {
            self.kept_bytes += message.data.len();
            channel.kept = Some(Kept {
                log_ns,
                data: message.data.clone(),
            });
        }
    }

    /// A client's wish, with what is kept on that channel. Channels that do not exist are passed over.
    fn subscribe(&mut self, id: ClientId, request: Subscription) {
        let mut channels = self.channels.values();
        let channel = channels.find(|channel| channel.id == request.channel_id);
        let (Some(channel), Some(client)) = (channel, self.clients.get_mut(&id)) else {
            return;
        };
        client.subscriptions.insert(channel.id, request.id);
        if let Some(kept) = &channel.kept {
            let frame = message_data(request.id, kept.log_ns, &kept.data);
            self.counts.dropped += client.push(frame);
        }
    }
}

impl Client {
    fn new() -> Self {
        Self {
            subscriptions: BTreeMap::new(),
            texts: VecDeque::new(),
            data: Queue::new(WAITING, DropRule::Oldest),
            ready: Arc::default(),
        }
    }

    /// There are no more texts than channels, and one.
    fn say(&mut self, text: String) {
        self.texts.push_back(text);
        self.ready.notify_one();
    }

    /// Queues a message; returns how many gave way.
    fn push(&mut self, frame: Vec<u8>) -> u64 {
        let bytes = frame.len();
        let dropped = self.data.push(frame, bytes);
        self.ready.notify_one();
        dropped
    }

    fn pop(&mut self) -> Option<Frame> {
        if let Some(text) = self.texts.pop_front() {
            return Some(Frame::Text(text));
        }
        self.data.try_pop().map(Frame::Binary)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sextant_recordings::foxglove::schema;
    use sextant_ros2::messages::Header;

    fn message(topic: &str, bytes: usize) -> ViewerMessage {
        ViewerMessage {
            topic: topic.to_owned(),
            schema: schema::ros::<Header>,
            data: vec![7; bytes],
        }
    }

    fn hub() -> Hub {
        Hub::new(&SiteId::new("lab").unwrap())
    }

    fn frames(hub: &Hub, client: ClientId) -> Vec<Frame> {
        std::iter::from_fn(|| hub.next_frame(client)).collect()
    }

    fn subscribe(hub: &Hub, client: ClientId) {
        let request = r#"{"op":"subscribe","subscriptions":[{"id":5,"channelId":1},{"id":6,"channelId":99}]}"#;
        hub.request(client, request);
    }

    #[test]
    fn messages_go_to_subscribers_and_models_wait_for_them() {
        let hub = hub();
        hub.publish(&message("/rig", 3), 1, Lifetime::UntilReplaced);
        hub.publish(&message("/rig", 2), 2, Lifetime::UntilReplaced);
        let (client, _) = hub.join().unwrap();
        assert_eq!(frames(&hub, client).len(), 2);
        subscribe(&hub, client);
        let kept = Frame::Binary(message_data(5, 2, &[7; 2]));
        assert_eq!(frames(&hub, client), [kept]);
        hub.publish(&message("/rig", 1), 3, Lifetime::Passing);
        hub.publish(&message("/new", 1), 4, Lifetime::Passing);
        let [Frame::Text(offer), Frame::Binary(data)] = &frames(&hub, client)[..] else {
            panic!("an offer and a message");
        };
        assert!(offer.contains("/new"));
        assert_eq!(*data, message_data(5, 3, &[7]));
        hub.request(client, r#"{"op":"unsubscribe","subscriptionIds":[5]}"#);
        hub.publish(&message("/rig", 1), 5, Lifetime::Passing);
        assert_eq!(frames(&hub, client), []);
        hub.leave(client);
        assert!(!hub.is_watched());
    }

    #[test]
    fn a_slow_client_loses_its_oldest_messages_and_no_other_does() {
        let hub = hub();
        hub.publish(&message("/rig", 1), 1, Lifetime::Passing);
        let [(slow, _), (quick, _)] = [hub.join().unwrap(), hub.join().unwrap()];
        for client in [slow, quick] {
            subscribe(&hub, client);
        }
        frames(&hub, quick);
        for n in 0..3 * WAITING.items as u64 {
            hub.publish(&message("/rig", 1), n, Lifetime::Passing);
            assert_eq!(
                frames(&hub, quick),
                [Frame::Binary(message_data(5, n, &[7]))]
            );
        }
        let waiting = frames(&hub, slow);
        assert_eq!(waiting.len(), WAITING.items + 2);
        let newest = 3 * WAITING.items as u64 - 1;
        assert_eq!(
            waiting.last(),
            Some(&Frame::Binary(message_data(5, newest, &[7])))
        );
        assert_eq!(hub.counts().dropped, 2 * WAITING.items as u64);
    }

    #[test]
    fn floods_end_at_the_bounds() {
        let hub = hub();
        let clients = (0..2 * MAX_CLIENTS).filter_map(|_| hub.join()).count();
        assert_eq!(clients, MAX_CLIENTS);
        for n in 0..MAX_CHANNELS + 10 {
            hub.publish(
                &message(&format!("/{n}"), 10_000),
                1,
                Lifetime::UntilReplaced,
            );
        }
        let state = hub.lock();
        assert_eq!(state.channels.len(), MAX_CHANNELS);
        assert!(state.kept_bytes <= MAX_KEPT_BYTES);
    }
}
