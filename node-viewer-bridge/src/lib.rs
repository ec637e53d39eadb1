//! Viewer bridge: the site as a web page and a WebSocket.
