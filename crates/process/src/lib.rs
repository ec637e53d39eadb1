//! What a process needs of its operating system: clock, shutdown, logging, memory, exit codes.
