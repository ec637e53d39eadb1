//! `sextant keys`: what it makes, who can read it, and what it refuses.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use serde_json::Value;
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::{Command, Output};

fn run(dir: &Path, command: &str, more: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_sextant"))
        .args(["--json", "keys", command])
        .arg(dir)
        .args(more)
        .output()
        .unwrap()
}

fn done(dir: &Path, command: &str, more: &[&str]) -> Vec<Value> {
    let output = run(dir, command, more);
    assert!(output.status.success(), "{output:?}");
    let text = String::from_utf8(output.stdout).unwrap();
    text.lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect()
}

/// Why it is refused.
fn refused(dir: &Path, command: &str, more: &[&str]) -> String {
    let output = run(dir, command, more);
    assert_eq!(output.status.code(), Some(3), "{output:?}");
    String::from_utf8(output.stderr).unwrap()
}

fn files_below(folder: &Path) -> Vec<std::path::PathBuf> {
    let entries = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path());
    let below = |path: std::path::PathBuf| {
        let more = if path.is_dir() {
            files_below(&path)
        } else {
            vec![]
        };
        std::iter::once(path).chain(more)
    };
    entries.flat_map(below).collect()
}

#[test]
fn secrets_are_for_their_owner_only() {
    let place = tempfile::tempdir().unwrap();
    let dir = place.path().join("keys");
    done(&dir, "init", &["--site", "lab"]);
    for (name, role) in [
        ("main", "fusion"),
        ("north", "camera"),
        ("desk", "operator"),
    ] {
        done(&dir, "add", &[name, "--role", role]);
    }
    done(&dir, "renew", &["north"]);
    let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode() & 0o777;
    assert_eq!(mode(&dir), 0o700);
    let mut secrets = 0;
    for path in files_below(&dir) {
        let name = path.file_name().unwrap().to_str().unwrap().to_owned();
        assert!(!name.starts_with('.'), "left behind: {}", path.display());
        let secret = [
            "key.pem",
            "authority.key",
            "page.key",
            "password",
            "passwords",
            "page-tokens.toml",
            "phones.toml",
        ];
        if path.is_dir() {
            assert_eq!(mode(&path), 0o700, "{}", path.display());
        } else if secret.contains(&name.as_str()) {
            secrets += 1;
            assert_eq!(mode(&path), 0o600, "{}", path.display());
        }
    }
    // Of the authority two, of each member two; of the router all passwords; of the operator the page's key and tokens,
    // and those of phones.
    assert_eq!(secrets, 2 + 3 * 2 + 1 + 3);
}

#[test]
fn pages_have_the_tokens_of_phones_until_those_are_revoked() {
    let place = tempfile::tempdir().unwrap();
    let dir = place.path().join("keys");
    done(&dir, "init", &["--site", "lab"]);
    done(&dir, "add", &["main", "--role", "fusion"]);
    done(&dir, "add", &["pocket", "--role", "phone"]);
    done(&dir, "add", &["desk", "--role", "viewer"]);
    let phones = || fs::read_to_string(dir.join("desk/phones.toml")).unwrap();
    let token = fs::read_to_string(dir.join("pocket/password")).unwrap();
    assert!(phones().contains(&format!("pocket = \"{token}\"")));
    assert!(!dir.join("main/phones.toml").exists());
    done(&dir, "revoke", &["pocket"]);
    assert!(!phones().contains(&token));
}

#[test]
fn members_come_are_renewed_and_go() {
    let place = tempfile::tempdir().unwrap();
    let dir = place.path().join("keys");
    done(&dir, "init", &["--site", "lab"]);
    done(&dir, "add", &["main", "--role", "fusion"]);
    let added = done(&dir, "add", &["north", "--role", "camera", "--days", "10"]);
    assert_eq!(added[0]["common_name"], "north.1");
    let read = |name: &str| fs::read_to_string(dir.join(name)).unwrap();
    let (certificate, password) = (read("north/certificate.pem"), read("north/password"));
    assert!(read("main/passwords").contains(&format!("north.1:{password}")));

    let renewed = done(&dir, "renew", &["north", "--days", "1000"]);
    assert_eq!(renewed[0]["common_name"], "north.1");
    assert!(renewed[0]["valid_until"].as_str() > added[0]["valid_until"].as_str());
    assert_ne!(read("north/certificate.pem"), certificate);
    assert_eq!(read("north/password"), password);

    done(&dir, "revoke", &["north"]);
    assert!(!dir.join("north").exists());
    assert!(!read("main/passwords").contains("north"));
    assert!(read("main/members.toml").contains("revoked = true"));
    let again = done(&dir, "add", &["north", "--role", "camera"]);
    assert_eq!(again[0]["common_name"], "north.2");
    let states: Vec<(String, String)> = done(&dir, "list", &[])
        .iter()
        .map(|line| (line["common_name"].to_string(), line["state"].to_string()))
        .collect();
    let expected = [
        ("main.1", "valid"),
        ("north.1", "revoked"),
        ("north.2", "valid"),
    ];
    let expected = expected.map(|(name, state)| (format!("{name:?}"), format!("{state:?}")));
    assert_eq!(states, expected);
}

#[test]
fn what_cannot_be_is_refused_with_a_remedy() {
    let place = tempfile::tempdir().unwrap();
    let dir = place.path().join("keys");
    let words = refused(&dir, "list", &[]);
    assert!(words.contains("`sextant keys init` makes one"), "{words}");
    done(&dir, "init", &["--site", "lab"]);
    let words = refused(&dir, "init", &["--site", "lab"]);
    assert!(
        words.contains("something in this folder already"),
        "{words}"
    );
    done(&dir, "add", &["north", "--role", "camera"]);
    let words = refused(&dir, "add", &["north", "--role", "camera"]);
    assert!(
        words.contains("north is a member already") && words.contains("renew"),
        "{words}"
    );
    let words = refused(&dir, "revoke", &["south"]);
    assert!(
        words.contains("no member") && words.contains("keys list"),
        "{words}"
    );
    let words = refused(&dir, "add", &["passwords", "--role", "viewer"]);
    assert!(words.contains("another name"), "{words}");
    fs::create_dir(dir.join("desk")).unwrap();
    let words = refused(&dir, "add", &["desk", "--role", "operator"]);
    assert!(words.contains("in the way"), "{words}");
    let words = refused(&dir, "add", &["main", "--role", "fusion", "--host", "a b"]);
    assert!(words.contains("--host"), "{words}");
}

#[test]
fn a_node_with_readable_secrets_or_foreign_keys_does_not_start() {
    let place = tempfile::tempdir().unwrap();
    let dir = place.path().join("keys");
    done(&dir, "init", &["--site", "lab"]);
    done(&dir, "add", &["north", "--role", "camera"]);
    let file = place.path().join("camera.toml");
    let write = |site: &str, security: &str| {
        let text = format!(
            "site = \"{site}\"\ncamera = \"north\"\n[source]\nkind = \"images\"\nfolder = \".\"\n\
             [network]\nconnect = [\"quic/fusion.lab:7447\"]\n[security]\n{security}\n"
        );
        fs::write(&file, text).unwrap();
    };
    let check = || {
        let output = Command::new(env!("CARGO_BIN_EXE_sextant"))
            .arg("check")
            .arg(&file)
            .output()
            .unwrap();
        let said = [output.stdout, output.stderr].concat();
        String::from_utf8(said).unwrap()
    };
    write("lab", "profile = \"site\"\nkeys = \"keys/north\"");
    let words = check();
    assert!(words.contains("security profile site: right"), "{words}");
    for (site, security, expected) in [
        ("lab", "profile = \"site\"", "needs keys"),
        ("lab", "keys = \"keys/north\"", "makes no use of keys"),
        (
            "lab",
            "profile = \"lab\"\nkeys = \"keys/north\"",
            "write tcp/ADDRESS:PORT",
        ),
        (
            "lab",
            "profile = \"site\"\nkeys = \"keys\"",
            "no keys of a node",
        ),
        (
            "gym",
            "profile = \"site\"\nkeys = \"keys/north\"",
            "camera north of site lab",
        ),
    ] {
        write(site, security);
        let words = check();
        assert!(words.contains(expected), "{security}: {words}");
    }
    write("lab", "profile = \"site\"\nkeys = \"keys/north\"");
    let key = dir.join("north/key.pem");
    fs::set_permissions(&key, fs::Permissions::from_mode(0o640)).unwrap();
    let words = check();
    assert!(words.contains("chmod 600"), "{words}");
}

/// What a kill in the middle of `keys add` leaves behind holds private keys.
#[test]
fn leftovers_of_a_killed_program_are_removed() {
    let folder = tempfile::tempdir().unwrap();
    let dir = folder.path().join("keys");
    done(&dir, "init", &["--site", "lab"]);
    done(&dir, "add", &["north", "--role", "camera"]);
    for name in [".south.7.tmp", "..north.7.tmp.7.tmp"] {
        fs::create_dir(dir.join(name)).unwrap();
        fs::write(dir.join(name).join("key.pem"), "private").unwrap();
    }
    fs::write(dir.join("north/.key.pem.7.tmp"), "private").unwrap();
    fs::create_dir(dir.join("notes")).unwrap();
    done(&dir, "renew", &["north"]);
    let names = files_below(&dir).into_iter();
    let names = names.map(|path| path.strip_prefix(&dir).unwrap().to_owned());
    let leftovers: Vec<_> = names
        .filter(|path| path.to_string_lossy().contains(".tmp"))
        .collect();
    assert!(leftovers.is_empty(), "{leftovers:?}");
    assert!(dir.join("notes").is_dir() && dir.join("north/node.toml").is_file());
}
