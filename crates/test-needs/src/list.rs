//! Everything that some test or chore needs.

use crate::need::{Check, Need, ability, program};

/// The page's build asks for this version.
pub const NODE: Need = ability(
    "Node.js 20.19 or newer, with npm",
    &[
        "sh",
        "-c",
        "npm --version && node -e 'const [a, b] = \
         process.versions.node.split(\".\").map(Number); process.exit(a > 20 || (a === 20 && b >= 19) ? 0 : 1)'",
    ],
    "install it (https://nodejs.org)",
);
/// As the page's checks find it.
pub const CHROMIUM: Need = Need {
    name: "Chromium",
    check: Check::Succeeds(&["sh", "-c", "test -x \"${CHROMIUM:-/usr/bin/chromium}\""]),
    package: Some("chromium"),
    remedy: "install it, and set CHROMIUM to its path where that is not /usr/bin/chromium",
};
pub const PYTHON: Need = Need {
    name: "Python 3.9 or newer, with its module venv",
    check: Check::Succeeds(&[
        "python3",
        "-c",
        "import ensurepip, sys, venv; sys.exit(sys.version_info < (3, 9))",
    ]),
    package: Some("python3-venv"),
    remedy: "install it",
};
pub const PIP: Need = program("pip3", "python3-pip", "install Python's pip");
/// A broker of MQTT.
pub const MOSQUITTO: Need = program("mosquitto", "mosquitto", "install Eclipse Mosquitto");
/// In place of MATLAB, with what it opens sockets by.
pub const OCTAVE: Need = Need {
    name: "GNU Octave with instrument-control",
    check: Check::Succeeds(&["octave-cli", "--eval", "pkg load instrument-control"]),
    package: Some("octave-instrument-control"),
    remedy: "install it",
};
pub const FFMPEG: Need = program("ffmpeg", "ffmpeg", "install FFmpeg");
pub const CXX: Need = program("c++", "g++", "install a C++ compiler");
pub const QEMU_ARM: Need = program(
    "qemu-arm",
    "qemu-user",
    "install qemu's user-mode emulation",
);
pub const QEMU_AARCH64: Need = program(
    "qemu-aarch64",
    "qemu-user",
    "install qemu's user-mode emulation",
);
/// In a root of its own, where there is no qemu.
pub const QEMU_BINFMT: Need = Need {
    name: "a kernel that runs programs of other processors by qemu",
    check: Check::Succeeds(&[
        "sh",
        "-c",
        "cd /proc/sys/fs/binfmt_misc && grep -q ^flags:.*F qemu-arm && grep -q ^flags:.*F qemu-aarch64",
    ]),
    package: Some("qemu-user-static"),
    remedy: "mount -t binfmt_misc none /proc/sys/fs/binfmt_misc, then install or reinstall \
        qemu-user-static with binfmt-support",
};
pub const GCC_ARM: Need = program(
    "arm-linux-gnueabihf-gcc",
    "gcc-arm-linux-gnueabihf",
    "install a C compiler for arm-linux-gnueabihf",
);
pub const GCC_AARCH64: Need = program(
    "aarch64-linux-gnu-gcc",
    "gcc-aarch64-linux-gnu",
    "install a C compiler for aarch64-linux-gnu",
);
pub const IP: Need = program("ip", "iproute2", "install iproute2");
/// Its package brings the client and `ssh-keygen` too.
pub const SSHD: Need = program("sshd", "openssh-server", "install the OpenSSH server");
pub const DPKG_DEB: Need = Need {
    name: "dpkg-deb",
    check: Check::OnPath,
    package: None,
    remedy: "use Debian or one of its descendants",
};
pub const SYSUSERS: Need = program("systemd-sysusers", "systemd", "install systemd");
pub const LINTIAN: Need = program("lintian", "lintian", "install lintian");
pub const QEMU_SYSTEM_ARM: Need = program(
    "qemu-system-arm",
    "qemu-system-arm",
    "install qemu's system emulation",
);
pub const MMDEBSTRAP: Need = program("mmdebstrap", "mmdebstrap", "install mmdebstrap");
pub const KMOD: Need = program("depmod", "kmod", "install kmod");
pub const CPIO: Need = program("cpio", "cpio", "install cpio");
pub const MKE2FS: Need = program("mke2fs", "e2fsprogs", "install e2fsprogs");

pub const NAME_SPACES: Need = ability(
    "name spaces for mounts, network and processes",
    &[
        "unshare",
        "--mount",
        "--net",
        "--pid",
        "--fork",
        "--mount-proc",
        "true",
    ],
    "run the tests as root; in a container, with --privileged",
);
pub const USER_NAME_SPACES: Need = ability(
    "name spaces for users, mounts and network",
    &[
        "unshare",
        "--user",
        "--map-root-user",
        "--mount",
        "--net",
        "mount",
        "-t",
        "tmpfs",
        "tmpfs",
        "/opt",
    ],
    "let the kernel give them to users (sysctl kernel.unprivileged_userns_clone and \
     kernel.apparmor_restrict_unprivileged_userns); in a container, with --privileged",
);
/// Over a root that has this machine's programs and packages, not only places for other file systems.
pub const OVERLAYFS: Need = ability(
    "overlayfs over a root file system with /usr, /etc and /var on it",
    &[
        "unshare",
        "--mount",
        "sh",
        "-ec",
        "mount -t tmpfs tmpfs /mnt; cd /mnt; mkdir u w r; mount -t overlay overlay -o \
         lowerdir=/,upperdir=u,workdir=w r; test -d r/var/lib/dpkg; chroot r true",
    ],
    "run the tests on a machine with such a root",
);

/// Images that pass between processes, of the sites that run at a time.
pub const SHARED_MEMORY: Need = Need {
    name: "256 MiB of free shared memory",
    check: Check::RoomMib("/dev/shm", 256),
    package: None,
    remedy: "make room in /dev/shm, or enlarge it (mount -o remount,size=1G /dev/shm; in a container: --shm-size 1g)",
};
/// All that is compiled, for every target.
pub const DISK: Need = Need {
    name: "12 GiB of disk space for the folder target",
    check: Check::RoomMib("target", 12 << 10),
    package: None,
    remedy: "make room, or let target be a link to where there is some",
};

/// Everything of which a Debian package is installed.
pub const PACKAGED: &[&Need] = &[
    &CHROMIUM,
    &PYTHON,
    &PIP,
    &FFMPEG,
    &MOSQUITTO,
    &OCTAVE,
    &CXX,
    &QEMU_ARM,
    &QEMU_AARCH64,
    &QEMU_BINFMT,
    &GCC_ARM,
    &GCC_AARCH64,
    &IP,
    &SSHD,
    &SYSUSERS,
    &LINTIAN,
    &QEMU_SYSTEM_ARM,
    &MMDEBSTRAP,
    &KMOD,
    &CPIO,
    &MKE2FS,
];
