//! From pixels to decoded tags with sub-pixel corners.
