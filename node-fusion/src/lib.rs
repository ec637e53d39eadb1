//! Fusion node: observations of every camera to one pose an object.
