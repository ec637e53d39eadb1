//! What a release consists of, made and checked. Nothing here uploads anything.

use crate::package::{self, VERSION};
use crate::python;
use crate::tools::{copy, root, run, run_in};
use std::fs;
use std::path::PathBuf;

/// Run where nothing but the package is installed.
const NPM_TRIAL: &str = "import { Detector } from 'sextant-web';
const detector = await Detector.load({ families: ['tag36h11'] });
const tags = detector.detect({ data: new Uint8Array(640 * 480), width: 640, height: 480 });
if (tags.length !== 0) throw new Error('tags in a black picture');
";
/// Names, sizes and checksums of all that is in the folder `$1`.
const SUMS: &str = "cd \"$1\"
sha256sum -- * > ../sums && mv ../sums SHA256SUMS
sha256sum --check --quiet SHA256SUMS
ls -l --human-readable";

/// Each crate is packed as for crates.io and compiles from its package alone, in the order of an upload.
pub fn crates_io() -> Result<(), String> {
    run("cargo", &["publish", "--workspace", "--dry-run"])
}

/// The package for npm, in `target/package/npm`: installed into an empty folder, it finds no tag in a black picture.
pub fn npm() -> Result<(), String> {
    let folder = package::fresh_folder("npm")?;
    let place = folder.display().to_string();
    let pack = ["pack", "--silent", "--pack-destination", &place];
    run_in("clients/web", "npm", &pack)?;
    let packed = folder.join(format!("sextant-web-{VERSION}.tgz"));
    let trial = package::fresh_folder("trial")?;
    let script = trial.join("trial.mjs");
    fs::write(&script, NPM_TRIAL).map_err(|cause| format!("{}: {cause}", script.display()))?;
    let [trial, packed] = [trial, packed].map(|path| path.display().to_string());
    let install = ["install", "--silent", "--no-audit", &packed];
    run_in(&trial, "npm", &install)?;
    run_in(&trial, "node", &["trial.mjs"])
}

/// All of it in one folder, with the notes of the changelog and checksums: `target/releases/VERSION`.
pub fn assemble() -> Result<(), String> {
    let folder = root().join("target/releases").join(VERSION);
    let failed = |cause| format!("{}: {cause}", folder.display());
    if folder.exists() {
        fs::remove_dir_all(&folder).map_err(failed)?;
    }
    for file in files()? {
        copy(&file, &folder, 0o644)?;
    }
    let python = python::environment(&root().join("target/python/venv"))?;
    python::source_package(&python, &folder)?;
    let changelog = fs::read_to_string(root().join("CHANGELOG.md")).map_err(failed)?;
    let (title, notes) = notes(&changelog)?;
    if title.contains("unreleased") {
        println!(
            "xtask: CHANGELOG.md calls {VERSION} unreleased: write its date there before it is published"
        );
    }
    fs::write(folder.join("NOTES.md"), notes).map_err(failed)?;
    run("sh", &["-ec", SUMS, "sh", &folder.display().to_string()])
}

/// What other chores have made, in the current version.
fn files() -> Result<Vec<PathBuf>, String> {
    let packages = root().join("target/package");
    let mut files = vec![root().join("target/sbom/sextant.cdx.json")];
    let folders = [
        packages.clone(),
        packages.join("npm"),
        packages.join("wheels/any"),
        packages.join("wheels/aarch64"),
        packages.join("wheels/x86_64"),
    ];
    for folder in folders {
        let failed = |cause| format!("{}: {cause}", folder.display());
        for entry in fs::read_dir(&folder).map_err(failed)? {
            let path = entry.map_err(failed)?.path();
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            if path.is_file() && name.contains(VERSION) {
                files.push(path);
            }
        }
    }
    Ok(files)
}

/// The title and the text of the changelog's section about this version.
fn notes(changelog: &str) -> Result<(&str, &str), String> {
    let sections = changelog.split("\n## ").skip(1);
    let section = sections
        .filter_map(|section| section.split_once('\n'))
        .find(|(title, _)| title.split(' ').next() == Some(VERSION));
    section.map_or_else(
        || Err(format!("CHANGELOG.md has no section '## {VERSION}'")),
        |(title, text)| Ok((title, text.trim())),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_package_manager_is_given_the_same_version() {
        for (file, line) in [
            ("Cargo.toml", format!("\nversion = \"{VERSION}\"\n")),
            (
                "clients/python/pyproject.toml",
                format!("\nversion = \"{VERSION}\"\n"),
            ),
            (
                "clients/web/package.json",
                format!("\n  \"version\": \"{VERSION}\",\n"),
            ),
        ] {
            assert!(
                fs::read_to_string(root().join(file))
                    .unwrap()
                    .contains(&line),
                "{file}"
            );
        }
    }

    #[test]
    fn the_changelog_has_a_section_of_this_version() {
        let changelog = fs::read_to_string(root().join("CHANGELOG.md")).unwrap();
        let (_, notes) = notes(&changelog).unwrap();
        assert!(notes.starts_with("- ") && !notes.contains("\n## "));
    }
}
