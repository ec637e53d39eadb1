//! Opens the page in the browser, where there is one.

use std::process::{Command, Stdio};

/// Programs that open an address in the default browser, most specific first.
const OPENERS: &[&str] = &["xdg-open", "gio", "open"];

/// Opens `url`; false without a display or a browser.
pub fn open(url: &str) -> bool {
    let display = ["DISPLAY", "WAYLAND_DISPLAY"]
        .iter()
        .any(|name| std::env::var_os(name).is_some_and(|v| !v.is_empty()));
    display && OPENERS.iter().any(|opener| launch(opener, url))
}

fn launch(opener: &str, url: &str) -> bool {
    let mut command = Command::new(opener);
    if opener == "gio" {
        command.arg("open");
    }
    command
        .arg(url)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .is_ok()
}
