//! A line for each host: redrawn in place on a terminal, one after the other elsewhere. Progress goes to standard
//! error.

use indicatif::{MultiProgress, ProgressBar, ProgressFinish, ProgressStyle};

/// The lines of all hosts of a deployment.
pub struct Progress {
    lines: MultiProgress,
    hosts: Vec<ProgressBar>,
}

impl Progress {
    /// A line for each of these hosts.
    pub fn new(hosts: impl Iterator<Item = String>) -> Self {
        let lines = MultiProgress::new();
        let style = ProgressStyle::with_template("{prefix:24} {msg}");
        let style = style.unwrap_or_else(|_| ProgressStyle::default_spinner());
        let line = |host| {
            let line = ProgressBar::no_length()
                .with_style(style.clone())
                .with_prefix(host)
                .with_finish(ProgressFinish::Abandon);
            let line = lines.add(line);
            line.tick();
            line
        };
        let hosts = hosts.map(line).collect();
        Self { lines, hosts }
    }

    /// Where a host is now.
    pub fn say(&self, host: usize, words: &str) {
        let line = &self.hosts[host];
        if line.message() == words {
            return;
        }
        line.set_message(words.to_owned());
        line.tick();
        if self.lines.is_hidden() {
            eprintln!("{}: {words}", line.prefix());
        }
    }
}
