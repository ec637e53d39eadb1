//! An emulated Cortex-A9 with Debian on it, and a shell on it: qemu's vexpress-a9, started from the files that
//! `cargo xtask board` makes.
//!
//! The machine's first serial line is its console, kept in a file; the second one takes commands (`tests/board/root`).
//! It reaches this host's loopback as [`HOST`]. Nothing that it writes to its disk is kept.

use std::fs;
use std::io::{Read, Write};
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// How long the board may take for a command, or to start: emulation is slow, and machines are shared.
const PATIENCE: Duration = Duration::from_secs(300);
/// This host, as the board sees it.
pub const HOST: &str = "10.0.2.2";
/// Ends what a command writes.
const SEPARATOR: u8 = 0x1e;

/// The running board. Dropping it ends it.
pub struct Board {
    qemu: Child,
    shell: UnixStream,
    unread: Vec<u8>,
    console: PathBuf,
}

impl Board {
    /// Starts the board from the files in `image`, with a second disk labelled `payload` that has the files of
    /// `payload` on it. `folder` is for its own files. Returns when it takes commands.
    ///
    /// # Panics
    /// When it does not come up.
    #[must_use]
    pub fn start(image: &Path, payload: &Path, folder: &Path) -> Self {
        let second_disk = folder.join("payload.ext4");
        make_disk(payload, &second_disk);
        let (console, socket) = (folder.join("console"), folder.join("shell"));
        let mut command = Command::new("qemu-system-arm");
        command
            .args([
                "-machine",
                "vexpress-a9",
                "-smp",
                "2",
                "-m",
                "1024",
                "-snapshot",
            ])
            .args([
                "-display",
                "none",
                "-monitor",
                "none",
                "-audiodev",
                "none,id=none",
            ])
            .arg("-kernel")
            .arg(image.join("kernel"))
            .arg("-initrd")
            .arg(image.join("initramfs"))
            .arg("-dtb")
            .arg(image.join("device-tree"))
            .args([
                "-append",
                "console=ttyAMA0 loglevel=4 systemd.show_status=0",
            ])
            .args([
                "-netdev",
                "user,id=net",
                "-device",
                "virtio-net-device,netdev=net",
            ])
            .args(["-serial", &format!("file:{}", console.display())])
            .args([
                "-serial",
                &format!("unix:{},server=on,wait=off", socket.display()),
            ]);
        // The last device has the first place on the bus.
        for (name, file) in [("second", &second_disk), ("first", &image.join("disk"))] {
            let file = file.display();
            command
                .args([
                    "-drive",
                    &format!("if=none,format=raw,id={name},file={file}"),
                ])
                .args(["-device", &format!("virtio-blk-device,drive={name}")]);
        }
        let qemu = command
            .stdin(Stdio::null())
            .spawn()
            .expect("qemu-system-arm starts");
        let shell = connect(&socket);
        let mut board = Self {
            qemu,
            shell,
            unread: Vec::new(),
            console,
        };
        board.await_start();
        board
    }

    fn await_start(&mut self) {
        let (_, said) = self.answer("the board's start");
        assert_eq!(said, "ready");
    }

    /// Runs a line of shell as root and gives what it wrote.
    ///
    /// # Panics
    /// When it fails, or does not end in time.
    pub fn run(&mut self, line: &str) -> String {
        let (written, code) = self.attempt(line);
        assert_eq!(code, 0, "{line}\n{written}");
        written
    }

    /// The same with its exit code.
    ///
    /// # Panics
    /// When it does not end in time.
    pub fn attempt(&mut self, line: &str) -> (String, i32) {
        assert!(!line.contains('\n'), "one line at a time");
        println!("board# {line}");
        self.shell
            .write_all(format!("{line}\n").as_bytes())
            .expect("the board's shell reads");
        let (written, code) = self.answer(line);
        (written, code.parse().expect("an exit code"))
    }

    /// Repeats a line until it succeeds.
    ///
    /// # Panics
    /// When it does not in time; says what it wrote last.
    pub fn until(&mut self, line: &str) {
        let deadline = Instant::now() + PATIENCE;
        loop {
            let (written, code) = self.attempt(&format!("{line} || {{ sleep 1; false; }}"));
            if code == 0 {
                return;
            }
            assert!(Instant::now() < deadline, "never: {line}\n{written}");
        }
    }

    /// Has the board start anew, as after a loss of power that its file system survived.
    ///
    /// # Panics
    /// When it does not come back.
    pub fn reboot(&mut self) {
        println!("board# reboot");
        self.shell
            .write_all(b"sync; echo b >/proc/sysrq-trigger\n")
            .expect("the board's shell reads");
        self.await_start();
    }

    /// Up to the next separator, and the line behind it.
    fn answer(&mut self, of: &str) -> (String, String) {
        let deadline = Instant::now() + PATIENCE;
        loop {
            if let Some(answer) = self.next_answer() {
                return answer;
            }
            let mut bytes = [0; 4096];
            match self.shell.read(&mut bytes) {
                Ok(length) if length > 0 => self.unread.extend(&bytes[..length]),
                Err(cause) if Instant::now() < deadline && is_no_answer_yet(&cause) => {}
                _ => panic!("{of}: no answer; the console says\n{}", self.console()),
            }
        }
    }

    fn next_answer(&mut self) -> Option<(String, String)> {
        let separator = self.unread.iter().position(|byte| *byte == SEPARATOR)?;
        let end = separator
            + self.unread[separator..]
                .iter()
                .position(|byte| *byte == b'\n')?;
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        let answer = (
            text(&self.unread[..separator]),
            text(&self.unread[separator + 1..end]),
        );
        self.unread.drain(..=end);
        Some(answer)
    }

    /// The end of what the kernel and systemd said.
    fn console(&self) -> String {
        let bytes = fs::read(&self.console).unwrap_or_default();
        let end = bytes.len().saturating_sub(8000);
        String::from_utf8_lossy(&bytes[end..]).into_owned()
    }
}

impl Drop for Board {
    fn drop(&mut self) {
        let _ = self.qemu.kill();
        let _ = self.qemu.wait();
    }
}

fn is_no_answer_yet(cause: &std::io::Error) -> bool {
    use std::io::ErrorKind::{Interrupted, TimedOut, WouldBlock};
    matches!(cause.kind(), Interrupted | TimedOut | WouldBlock)
}

fn make_disk(files: &Path, disk: &Path) {
    let status = Command::new("mke2fs")
        .args(["-q", "-t", "ext4", "-L", "payload", "-d"])
        .args([files, disk])
        .arg("128M")
        .status()
        .expect("mke2fs runs: it comes with e2fsprogs");
    assert!(status.success(), "mke2fs: {status}");
}

/// qemu makes the socket when it has started.
fn connect(socket: &Path) -> UnixStream {
    let deadline = Instant::now() + PATIENCE;
    loop {
        match UnixStream::connect(socket) {
            Ok(stream) => {
                let limit = Some(Duration::from_secs(1));
                stream.set_read_timeout(limit).expect("a socket");
                return stream;
            }
            Err(cause) => assert!(Instant::now() < deadline, "qemu: {cause}"),
        }
        std::thread::sleep(Duration::from_millis(50));
    }
}
