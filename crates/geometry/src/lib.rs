//! Rigid motions, lenses, homographies and planar pose.
