//! The wire contract: messages, keys, versions and limits.
