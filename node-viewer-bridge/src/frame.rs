//! Frames of a WebSocket, as clients receive them.

use axum::extract::ws;
use serde::Serialize;

/// One WebSocket frame, shared by all clients without a copy.
pub(crate) type Frame = ws::Message;

/// A message as JSON.
pub(crate) fn frame_of(message: &impl Serialize) -> Frame {
    // Plain data with string keys: writing it into memory cannot fail.
    Frame::Text(serde_json::to_string(message).unwrap_or_default().into())
}

/// Bytes of a frame.
pub(crate) fn length(frame: &Frame) -> usize {
    match frame {
        Frame::Text(text) => text.len(),
        Frame::Binary(bytes) => bytes.len(),
        _ => 0,
    }
}
