//! What a site needs of this machine: its clock, shared memory, temporary files, cameras.

use crate::doctor::Finding;
use sextant_iceoryx_images::{IceoryxOptions, open_own_folder};
use sextant_process::clock::is_plausible;
use sextant_process::{ClockQuality, host, now_ns};
use std::fs::{self, OpenOptions};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// Shared memory that a few cameras need: eight images of 2 megapixels for each of four.
const ENOUGH_SHARED_BYTES: u64 = 64 << 20;
/// Images of one camera of 2 megapixels.
const IMAGES_BYTES: u64 = 16 << 20;
/// Error of a clock from which on poses suffer: 1 mm at 1 m/s.
const GOOD_CLOCK_NS: u64 = 1_000_000;

/// All findings about this machine.
pub fn findings() -> Vec<Finding> {
    let mut findings = vec![
        clock(now_ns(), ClockQuality::read()),
        shared_memory(Path::new("/dev/shm")),
        bookkeeping(&IceoryxOptions::default().root),
    ];
    findings.extend(cameras(Path::new("/dev")));
    findings
}

fn clock(now_ns: u64, clock: ClockQuality) -> Finding {
    let error_ms = clock.error_ns as f64 / 1e6;
    match clock {
        _ if !is_plausible(now_ns) => Finding::fault(
            "clock",
            "it shows a time before this program was written, so that nothing can be said of its images' times",
            "set it: by chrony (deploy/chrony), or by hand with `date --set`",
        ),
        ClockQuality {
            synchronised: false,
            ..
        } => Finding::warning(
            "clock",
            "nothing keeps this machine's clock right",
            "install chrony and let all machines of the site follow one; one machine alone needs none",
        ),
        ClockQuality { error_ns, .. } if error_ns > GOOD_CLOCK_NS => Finding::warning(
            "clock",
            format!("synchronised, estimated error {error_ms:.1} ms"),
            "chrony states and reaches less than 1 ms in a local network",
        ),
        _ => Finding::ok(
            "clock",
            format!("synchronised, estimated error {error_ms:.2} ms"),
        ),
    }
}

/// Images are handed on in `/dev/shm`.
fn shared_memory(folder: &Path) -> Finding {
    let name = folder.display();
    if let Err(cause) = try_to_write(folder) {
        return Finding::fault(
            "shared memory",
            format!("{name} can't be written: {cause}"),
            "mount a tmpfs there; in a container give it --shm-size",
        );
    }
    let mounts = fs::read_to_string("/proc/mounts").unwrap_or_default();
    let size = size_of_mount(&mounts, folder);
    room(&name.to_string(), size, host::free_bytes(folder))
}

/// What its size and its free bytes are enough for.
fn room(name: &str, size: Option<u64>, free: Option<u64>) -> Finding {
    if let Some(bytes) = size.filter(|bytes| *bytes < IMAGES_BYTES) {
        return Finding::fault(
            "shared memory",
            format!(
                "{name} holds {} MB, too little for the images of one camera of 2 megapixels",
                bytes >> 20
            ),
            "enlarge it (`mount -o remount,size=128M`); in a container give it --shm-size",
        );
    }
    if let Some(bytes) = free.filter(|bytes| *bytes < IMAGES_BYTES) {
        return Finding::fault(
            "shared memory",
            format!("{name} is full: {} MB are free", bytes >> 20),
            "end what fills it (`ls -l /dev/shm`); a camera node removes what its dead \
             predecessors left when it starts",
        );
    }
    match size {
        Some(bytes) if bytes < ENOUGH_SHARED_BYTES => Finding::warning(
            "shared memory",
            format!("{name} holds {} MB", bytes >> 20),
            "a camera of 2 megapixels takes 16 MB; enlarge it (`mount -o remount,size=128M`)",
        ),
        Some(bytes) => Finding::ok("shared memory", format!("{name} holds {} MB", bytes >> 20)),
        None => Finding::ok("shared memory", format!("{name} can be written")),
    }
}

/// Creates a file and removes it. It fails where the name exists and follows no link, since root may run this in
/// world-writable folders.
fn try_to_write(folder: &Path) -> std::io::Result<()> {
    let probe = folder.join(format!(".sextant-doctor-{}", std::process::id()));
    OpenOptions::new()
        .write(true)
        .create_new(true)
        .open(&probe)?;
    fs::remove_file(&probe)
}

/// The size that a tmpfs was mounted with, bytes.
fn size_of_mount(mounts: &str, folder: &Path) -> Option<u64> {
    let folder = folder.to_str()?;
    let mut lines = mounts
        .lines()
        .map(|line| line.split(' ').collect::<Vec<_>>());
    let fields = lines.rfind(|fields| fields.get(1) == Some(&folder))?;
    let mut options = fields.get(3)?.split(',');
    let size = options.find_map(|option| option.strip_prefix("size="))?;
    let kilobytes: u64 = size.strip_suffix('k')?.parse().ok()?;
    kilobytes.checked_mul(1024)
}

/// The folder where the processes of a camera meet: this user's own, or one that can be made.
fn bookkeeping(root: &Path) -> Finding {
    let name = root.display();
    let remedy = "all processes of a camera run as one user; remove what another user left, or \
        name another folder in [shared_memory]";
    if fs::symlink_metadata(root).is_ok() {
        return match open_own_folder(root) {
            Ok(_) => Finding::ok("folder", format!("{name} is this user's own")),
            Err(cause) => Finding::fault("folder", format!("{name}: {cause}"), remedy),
        };
    }
    let existing = root.ancestors().find(|folder| folder.is_dir());
    match existing.map(try_to_write) {
        Some(Ok(())) => Finding::ok("folder", format!("{name} can be made")),
        Some(Err(cause)) => {
            Finding::fault("folder", format!("{name} can't be made: {cause}"), remedy)
        }
        None => Finding::fault("folder", format!("{name} has no parent"), "make it"),
    }
}

/// The cameras that V4L2 knows, and whether they may be opened.
fn cameras(dev: &Path) -> Vec<Finding> {
    let entries = fs::read_dir(dev).into_iter().flatten().flatten();
    let is_video = |path: &PathBuf| {
        let name = path
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        name.strip_prefix("video")
            .is_some_and(|number| number.parse::<u32>().is_ok())
    };
    let mut devices: Vec<PathBuf> = entries.map(|entry| entry.path()).filter(is_video).collect();
    devices.sort();
    if devices.is_empty() {
        return vec![Finding::warning(
            "cameras",
            "no camera (/dev/video*)",
            "a board needs one; fusion and page need none",
        )];
    }
    devices.iter().map(|device| camera(device)).collect()
}

fn camera(device: &Path) -> Finding {
    let name = device.display();
    match OpenOptions::new().read(true).write(true).open(device) {
        Ok(_) => Finding::ok("camera", format!("{name} can be opened")),
        Err(cause) if cause.kind() == ErrorKind::PermissionDenied => Finding::fault(
            "camera",
            format!("{name} may not be opened by this user"),
            "add the user to the group `video` and log in again",
        ),
        Err(cause) => Finding::warning(
            "camera",
            format!("{name} can't be opened: {cause}"),
            "end the program that holds it",
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::doctor::Verdict;

    #[test]
    fn a_clock_that_nobody_keeps_is_a_warning() {
        let found_at = |now_ns, synchronised, error_ns| {
            let quality = ClockQuality {
                synchronised,
                error_ns,
            };
            clock(now_ns, quality).verdict
        };
        let found = |synchronised, error_ns| found_at(now_ns(), synchronised, error_ns);
        let in_2018_ns = 1_520_000_000_000_000_000;
        assert_eq!(found_at(in_2018_ns, true, 100_000), Verdict::Fault);
        assert_eq!(found(false, 16_000_000_000), Verdict::Warning);
        assert_eq!(found(true, 5_000_000), Verdict::Warning);
        assert_eq!(found(true, 100_000), Verdict::Ok);
    }

    #[test]
    fn a_small_or_missing_shared_memory_is_reported() {
        let mounts = "tmpfs /dev/shm tmpfs rw,size=65536k 0 0\ntmpfs /run tmpfs rw 0 0\n";
        let size = |folder| size_of_mount(mounts, Path::new(folder));
        assert_eq!((size("/dev/shm"), size("/run")), (Some(64 << 20), None));
        let missing = shared_memory(Path::new("/nowhere"));
        assert_eq!(missing.verdict, Verdict::Fault);
        let small = room("/dev/shm", Some(8 << 20), Some(8 << 20));
        assert!(small.words.contains("holds 8 MB, too little"), "{small:?}");
        let full = room("/dev/shm", Some(64 << 20), Some(8 << 20));
        assert!(full.words.contains("is full: 8 MB are free"), "{full:?}");
    }

    #[test]
    fn a_link_in_the_way_is_not_followed() {
        let folder = tempfile::tempdir().unwrap();
        let victim = folder.path().join("victim");
        fs::write(&victim, "content").unwrap();
        let probe = format!(".sextant-doctor-{}", std::process::id());
        std::os::unix::fs::symlink(&victim, folder.path().join(probe)).unwrap();
        let found = bookkeeping(&folder.path().join("sextant"));
        assert_eq!(found.verdict, Verdict::Fault);
        assert_eq!(fs::read(&victim).unwrap(), b"content");
    }

    #[test]
    fn devices_are_looked_at_one_by_one() {
        let folder = tempfile::tempdir().unwrap();
        let verdicts = |folder: &Path| -> Vec<Verdict> {
            cameras(folder)
                .iter()
                .map(|finding| finding.verdict)
                .collect()
        };
        assert_eq!(verdicts(folder.path()), [Verdict::Warning]);
        for name in ["video0", "video10", "videodev"] {
            fs::write(folder.path().join(name), "").unwrap();
        }
        assert_eq!(verdicts(folder.path()), [Verdict::Ok, Verdict::Ok]);
    }
}
