//! The TOML files people write: rig, object and node configuration.
