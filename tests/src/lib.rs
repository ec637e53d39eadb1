//! Whole-system tests: several processes, several hosts.
