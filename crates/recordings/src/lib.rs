//! Recorded images, detections and poses on disk.
