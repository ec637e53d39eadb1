//! Camera node: capture to shared memory, detection to the network.
