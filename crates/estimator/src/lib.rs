//! From tag corners of many cameras to object poses with covariance.
