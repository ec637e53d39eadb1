//! A bounded queue to a reader that may be slow. Whoever writes never waits: what finds no room gives way by a stated
//! rule and is counted.
//!
//! Items are bounded in number and bytes, and those of a stream by the time that they have waited. Items with a key are
//! state: a newer one takes the place of the unread one of its key. A reader takes what is there, waits in a thread, or
//! is woken as a task.

mod queue;

pub use queue::{DropRule, Queue, QueueCounts, StreamBounds};
