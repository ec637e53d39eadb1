//! Folders of this process's user, opened without following links, and removal of files in them. All access is by open
//! descriptors, so that nobody can replace a folder between check and removal.

use std::ffi::{CStr, CString};
use std::fs::File;
use std::io;
use std::os::unix::fs::MetadataExt;
use std::path::Path;

use rustix::fs::{AtFlags, CWD, Dir, FileType, Mode, OFlags, openat, statat, unlinkat};
use rustix::process::geteuid;

/// Permissions to write for group and others.
const WRITABLE_BY_OTHERS: u32 = 0o022;

/// Opens a folder that the effective user owns and no other user can write to. Links are not followed.
///
/// # Errors
/// What the system refuses; [`io::ErrorKind::PermissionDenied`] and [`io::ErrorKind::NotADirectory`] with the reason
/// and a remedy.
pub fn open_own_folder(path: &Path) -> io::Result<File> {
    checked(openat(CWD, path, flags(), Mode::empty()))
}

/// As [`open`], for an entry of an open folder.
pub(crate) fn open_own_folder_in(folder: &File, name: &CStr) -> io::Result<File> {
    checked(openat(folder, name, flags(), Mode::empty()))
}

fn flags() -> OFlags {
    OFlags::RDONLY | OFlags::DIRECTORY | OFlags::NOFOLLOW | OFlags::CLOEXEC
}

fn checked(opened: rustix::io::Result<std::os::fd::OwnedFd>) -> io::Result<File> {
    let folder = match opened {
        Err(rustix::io::Errno::NOTDIR | rustix::io::Errno::LOOP) => {
            let cause = "it is a link or no folder; remove it or name another folder";
            return Err(io::Error::new(io::ErrorKind::NotADirectory, cause));
        }
        opened => File::from(opened?),
    };
    let metadata = folder.metadata()?;
    let user = geteuid().as_raw();
    let refusal = if metadata.uid() != user {
        format!(
            "it belongs to user {}, but this process runs as user {user}; name a folder of that user's own",
            metadata.uid()
        )
    } else if metadata.mode() & WRITABLE_BY_OTHERS != 0 {
        "other users may write in it; take that from them with chmod go-w".to_owned()
    } else {
        return Ok(folder);
    };
    Err(io::Error::new(io::ErrorKind::PermissionDenied, refusal))
}

/// Names of this user's entries of a folder that begin with `prefix`: folders or files, without links.
pub(crate) fn own_entries(folder: &File, prefix: &str, are_folders: bool) -> Vec<CString> {
    let is_wanted = |name: &CStr| {
        let entry = statat(folder, name, AtFlags::SYMLINK_NOFOLLOW);
        entry.is_ok_and(|entry| {
            let kind = FileType::from_raw_mode(entry.st_mode);
            entry.st_uid == geteuid().as_raw()
                && kind != FileType::Symlink
                && (kind == FileType::Directory) == are_folders
        })
    };
    Dir::read_from(folder)
        .into_iter()
        .flatten()
        .flatten()
        .map(|entry| entry.file_name().to_owned())
        .filter(|name| name.to_bytes().starts_with(prefix.as_bytes()))
        .filter(|name| !matches!(name.to_bytes(), b"." | b"..") && is_wanted(name))
        .collect()
}

/// Removes this user's files in a folder whose names begin with `prefix`; returns their number.
pub(crate) fn remove_own_files(folder: &File, prefix: &str) -> usize {
    let files = own_entries(folder, prefix, false);
    let removed = files
        .iter()
        .filter(|name| unlinkat(folder, name.as_c_str(), AtFlags::empty()).is_ok());
    removed.count()
}

/// Removes a subfolder if it is empty.
pub(crate) fn remove_empty_folder(folder: &File, name: &CStr) {
    // Files of others stay.
    let _ = unlinkat(folder, name, AtFlags::REMOVEDIR);
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;
    use std::os::unix::fs::{PermissionsExt, symlink};

    #[test]
    fn a_link_a_file_and_a_folder_open_to_others_are_refused() {
        let parent = tempfile::tempdir().unwrap();
        let (folder, link, file) = (
            parent.path().join("folder"),
            parent.path().join("link"),
            parent.path().join("file"),
        );
        fs::create_dir(&folder).unwrap();
        fs::set_permissions(&folder, fs::Permissions::from_mode(0o755)).unwrap();
        symlink(&folder, &link).unwrap();
        fs::write(&file, "").unwrap();
        open_own_folder(&folder).unwrap();
        for refused in [&link, &file] {
            let cause = open_own_folder(refused).unwrap_err();
            assert_eq!(cause.kind(), io::ErrorKind::NotADirectory, "{cause}");
        }
        fs::set_permissions(&folder, fs::Permissions::from_mode(0o770)).unwrap();
        let cause = open_own_folder(&folder).unwrap_err();
        assert!(cause.to_string().contains("chmod go-w"), "{cause}");
    }

    #[test]
    fn only_own_files_of_the_prefix_are_removed_and_no_link() {
        let parent = tempfile::tempdir().unwrap();
        let path = |name: &str| parent.path().join(name);
        for name in ["a_1", "a_2", "b_1"] {
            fs::write(path(name), "").unwrap();
        }
        symlink(path("b_1"), path("a_link")).unwrap();
        fs::create_dir(path("a_folder")).unwrap();
        let folder = open_own_folder(parent.path()).unwrap();
        assert_eq!(remove_own_files(&folder, "a_"), 2);
        for name in ["b_1", "a_link", "a_folder"] {
            assert!(fs::symlink_metadata(path(name)).is_ok(), "{name}");
        }
    }
}
