//! A unit of deploy/systemd, and its program started with what systemd would let it see: the file system of the unit's
//! sandbox, its environment, its working directory, no capability. The unit's own file is read, so that the two cannot
//! part; a directive that is not known here fails the test. Needs name spaces of its own for user, mounts and network:
//! `unshare --user --map-root-user --mount --net`.
//!
//! Not imitated: users (the process is the owner of its folders, as systemd would make it), limits and filters of
//! system calls.

use crate::workspace_root;
use std::collections::BTreeMap;
use std::ffi::{CStr, CString};
use std::fs;
use std::io;
use std::os::fd::AsRawFd;
use std::os::unix::net::UnixDatagram;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command};

/// Directives that say what the process sees and starts with; all are obeyed.
const VIEW: &[&str] = &[
    "Environment",
    "ExecStart",
    "PrivateTmp",
    "ProtectHome",
    "ProtectSystem",
    "RuntimeDirectory",
    "RuntimeDirectoryMode",
    "RuntimeDirectoryPreserve",
    "StateDirectory",
    "StateDirectoryMode",
    "UMask",
    "WatchdogSec",
    "WorkingDirectory",
];
/// Directives that neither hide nor forbid a file that the programs use.
const OTHERS: &[&str] = &[
    "CapabilityBoundingSet",
    "DeviceAllow",
    "DevicePolicy",
    "EnvironmentFile",
    "Group",
    "LockPersonality",
    "MemoryDenyWriteExecute",
    "MemoryMax",
    "NoNewPrivileges",
    "NotifyAccess",
    "ProtectControlGroups",
    "ProtectHostname",
    "ProtectKernelLogs",
    "ProtectKernelModules",
    "ProtectKernelTunables",
    "ProtectProc",
    "Restart",
    "RestartPreventExitStatus",
    "RestartSec",
    "RestrictAddressFamilies",
    "RestrictNamespaces",
    "RestrictRealtime",
    "RestrictSUIDSGID",
    "SupplementaryGroups",
    "SystemCallArchitectures",
    "SystemCallErrorNumber",
    "SystemCallFilter",
    "TasksMax",
    "Type",
    "User",
];
/// systemd's folders for `StateDirectory` and `RuntimeDirectory`.
const STATE: &str = "/var/lib";
const RUNTIME: &str = "/run";
/// Where the programs under test stand in for those of `/usr/bin`.
const PROGRAMS: &str = "/opt";

/// The `[Service]` of a unit's file, for one instance.
#[derive(Debug)]
pub struct Unit {
    name: String,
    settings: BTreeMap<String, String>,
}

impl Unit {
    /// Reads `deploy/systemd/NAME.service`; `instance` stands for `%i`.
    ///
    /// # Panics
    /// When there is no such file, or it says something of which this does not know what it hides.
    #[must_use]
    pub fn read(name: &str, instance: &str) -> Self {
        let file = workspace_root().join(format!("deploy/systemd/{name}.service"));
        let text = fs::read_to_string(file).expect("the unit's file");
        let (_, service) = text.split_once("[Service]\n").expect("a service");
        let lines = service.lines().take_while(|line| !line.starts_with('['));
        let lines = lines.filter(|line| !line.is_empty() && !line.starts_with('#'));
        let mut settings = BTreeMap::new();
        for line in lines {
            let (key, value) = line.split_once('=').expect("a directive");
            let is_known = VIEW.contains(&key) || OTHERS.contains(&key);
            assert!(is_known, "{name}: what does {key} do to the files?");
            let value = value
                .replace("%i", instance)
                .replace("%S", STATE)
                .replace("%t", RUNTIME);
            let before = settings.insert(key.to_owned(), value);
            assert!(before.is_none() || OTHERS.contains(&key), "{key} twice");
        }
        let name = name.to_owned();
        let unit = Self { name, settings };
        for (key, value) in [
            ("ProtectSystem", "strict"),
            ("ProtectHome", "yes"),
            ("PrivateTmp", "yes"),
        ] {
            assert_eq!(unit.get(key), value, "{}: {key}", unit.name);
        }
        unit
    }

    fn get(&self, key: &str) -> &str {
        self.settings.get(key).map_or("", String::as_str)
    }

    /// The folder that it may write, made as systemd makes it.
    ///
    /// # Panics
    /// When the machine has none.
    #[must_use]
    pub fn state(&self) -> PathBuf {
        let folder = Path::new(STATE).join(self.get("StateDirectory"));
        make(&folder, self.get("StateDirectoryMode"));
        folder
    }

    /// Starts the program as the unit says; its watchdog's words come to the socket.
    ///
    /// # Panics
    /// When the name spaces are not there, or the program does not start.
    #[must_use]
    pub fn start(&self) -> (Child, UnixDatagram) {
        let mut writable = vec![self.state()];
        if self.settings.contains_key("RuntimeDirectory") {
            let folder = Path::new(RUNTIME).join(self.get("RuntimeDirectory"));
            make(&folder, self.get("RuntimeDirectoryMode"));
            writable.push(folder);
        }
        let notify = format!("{RUNTIME}/{}.notify", self.name);
        let watchdog = UnixDatagram::bind(&notify).expect("a socket");
        let mut words = self.get("ExecStart").split(' ');
        let program = words.next().and_then(|file| file.strip_prefix("/usr/bin/"));
        let program = Path::new(PROGRAMS).join(program.expect("a program of a package"));
        let mut command = Command::new(program);
        command
            .args(words)
            .env_clear()
            .envs(self.get("Environment").split_once('='))
            .env("NOTIFY_SOCKET", notify)
            .env(
                "WATCHDOG_USEC",
                format!("{}000000", self.get("WatchdogSec")),
            )
            .current_dir(self.get("WorkingDirectory"));
        let view = View::new(&writable, octal(self.get("UMask")));
        // SAFETY: between fork and exec only system calls run, on texts that were made before; nothing is allocated.
        unsafe { command.pre_exec(move || view.enter()) };
        (command.spawn().expect("the program starts"), watchdog)
    }
}

/// An empty `/var/lib` and `/run`, the programs under test, and a loopback interface: what the name spaces of the whole
/// test begin with. A workspace or build that is below one of these folders stays where it is.
///
/// # Panics
/// When this process may not do so.
pub fn prepare_machine(programs: &[Command]) {
    let emptied = [STATE, RUNTIME, PROGRAMS];
    let build = programs
        .iter()
        .filter_map(|program| Path::new(program.get_program()).parent());
    let kept = build.map(Path::to_owned).chain([workspace_root()]);
    let kept = kept.map(|folder| folder.canonicalize().expect("a folder"));
    let kept = kept.filter(|folder| emptied.iter().any(|hiding| folder.starts_with(hiding)));
    let kept: Vec<_> = kept
        .map(|folder| (fs::File::open(&folder).expect("a folder"), folder))
        .collect();
    for folder in emptied {
        mount_empty(&text(folder)).expect("a name space for mounts");
    }
    for (opened, folder) in &kept {
        fs::create_dir_all(folder).expect("a place for the folder");
        let opened = text(format!("/proc/self/fd/{}", opened.as_raw_fd()));
        mount(&opened, &text(folder), libc::MS_BIND | libc::MS_REC)
            .expect("the folder in its place");
    }
    for program in programs {
        let from = Path::new(program.get_program());
        let to = Path::new(PROGRAMS).join(from.file_name().expect("a program"));
        fs::write(&to, "").expect("a place for the program");
        mount(&text(from), &text(to), libc::MS_BIND).expect("the program in its place");
    }
    raise_loopback().expect("a name space for the network");
}

fn raise_loopback() -> io::Result<()> {
    // SAFETY: socket takes numbers only.
    let socket = unsafe { libc::socket(libc::AF_INET, libc::SOCK_DGRAM | libc::SOCK_CLOEXEC, 0) };
    // SAFETY: all zeros is a request without a name and flags.
    let mut request: libc::ifreq = unsafe { std::mem::zeroed() };
    for (to, from) in request.ifr_name.iter_mut().zip(b"lo") {
        *to = from.cast_signed();
    }
    request.ifr_ifru.ifru_flags = libc::IFF_UP as libc::c_short;
    // SAFETY: the request is a whole ifreq that lives through the call.
    let done = unsafe { libc::ioctl(socket, libc::SIOCSIFFLAGS, &raw const request) };
    // SAFETY: the socket is ours and is used no more.
    unsafe { libc::close(socket) };
    result(done)
}

/// What a process may see and write.
struct View {
    writable: Vec<CString>,
    read_only: Vec<CString>,
    umask: libc::mode_t,
    hidden: Vec<CString>,
    private: [CString; 2],
}

impl View {
    fn new(writable: &[PathBuf], umask: libc::mode_t) -> Self {
        let homes = ["/home", "/root", "/run/user"];
        let homes = homes.into_iter().filter(|home| Path::new(home).exists());
        Self {
            writable: writable.iter().map(text).collect(),
            read_only: mounts().iter().map(text).collect(),
            umask,
            hidden: homes.map(text).collect(),
            private: [text("/tmp"), text("/var/tmp")],
        }
    }

    /// What is writable becomes a mount of its own before all others turn read-only; the private folders come after
    /// that.
    fn enter(&self) -> io::Result<()> {
        // SAFETY: unshare takes a number only.
        result(unsafe { libc::unshare(libc::CLONE_NEWNS) })?;
        for folder in &self.writable {
            mount(folder, folder, libc::MS_BIND)?;
        }
        for folder in &self.read_only {
            set_read_only(folder)?;
        }
        for folder in self.hidden.iter().chain(&self.private) {
            mount_empty(folder)?;
        }
        for folder in &self.hidden {
            set_read_only(folder)?;
        }
        drop_capabilities()?;
        // SAFETY: umask takes a number only.
        unsafe { libc::umask(self.umask) };
        Ok(())
    }
}

fn drop_capabilities() -> io::Result<()> {
    for capability in 0..64 {
        // SAFETY: prctl takes numbers only here.
        if unsafe { libc::prctl(libc::PR_CAPBSET_DROP, capability, 0, 0, 0) } != 0 {
            // The kernel has no more of them.
            break;
        }
    }
    // SAFETY: as above.
    result(unsafe { libc::prctl(libc::PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) })
}

/// Where something is mounted, but for the kernel's own, which `ProtectSystem=strict` leaves as they are.
fn mounts() -> Vec<PathBuf> {
    let table = fs::read_to_string("/proc/self/mountinfo").expect("the table of mounts");
    let points = table.lines().filter_map(|line| line.split(' ').nth(4));
    let kernels = |point: &Path| {
        ["/dev", "/proc", "/sys"]
            .iter()
            .any(|own| point.starts_with(own))
    };
    points
        .map(PathBuf::from)
        .filter(|point| !kernels(point))
        .collect()
}

fn set_read_only(folder: &CStr) -> io::Result<()> {
    let attributes = libc::mount_attr {
        attr_set: libc::MOUNT_ATTR_RDONLY,
        attr_clr: 0,
        propagation: 0,
        userns_fd: 0,
    };
    // SAFETY: path and attributes live through the call, and the size is that of the attributes.
    let done = unsafe {
        libc::syscall(
            libc::SYS_mount_setattr,
            libc::AT_FDCWD,
            folder.as_ptr(),
            0,
            &raw const attributes,
            size_of::<libc::mount_attr>(),
        )
    };
    match io::Error::last_os_error() {
        _ if done == 0 => Ok(()),
        // Something else is mounted over it, so that nobody sees it.
        cause if matches!(cause.raw_os_error(), Some(libc::ENOENT | libc::EINVAL)) => Ok(()),
        cause => Err(cause),
    }
}

fn mount_empty(folder: &CStr) -> io::Result<()> {
    // SAFETY: the texts live through the call.
    result(unsafe {
        libc::mount(
            c"none".as_ptr(),
            folder.as_ptr(),
            c"tmpfs".as_ptr(),
            0,
            std::ptr::null(),
        )
    })
}

fn mount(from: &CStr, to: &CStr, flags: libc::c_ulong) -> io::Result<()> {
    // SAFETY: the texts live through the call.
    result(unsafe {
        libc::mount(
            from.as_ptr(),
            to.as_ptr(),
            std::ptr::null(),
            flags,
            std::ptr::null(),
        )
    })
}

fn result(done: libc::c_int) -> io::Result<()> {
    match done {
        0 => Ok(()),
        _ => Err(io::Error::last_os_error()),
    }
}

fn make(folder: &Path, mode: &str) {
    use std::os::unix::fs::DirBuilderExt;
    let mut builder = fs::DirBuilder::new();
    builder.recursive(true).mode(octal(mode));
    builder.create(folder).expect("a folder");
}

fn octal(text: &str) -> libc::mode_t {
    libc::mode_t::from_str_radix(text, 8).expect("an octal number")
}

fn text(path: impl AsRef<Path>) -> CString {
    CString::new(path.as_ref().as_os_str().as_encoded_bytes()).expect("a path")
}
