//! Seeded scenes rendered to images, with truth, clock and network faults.
