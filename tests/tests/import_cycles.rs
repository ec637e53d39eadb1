//! The imports between the files of a package run in one direction, and so do those between its top-level modules.
//!
//! File A imports file B where A names an item of B by a path that begins with `crate::` or `super::`; re-exports are
//! followed to the file that has the item. A module that names its own children (`use child::Item`) is composed of them
//! and does not import them. Test code does not count.

#![allow(clippy::expect_used, reason = "a test ends by panicking")]

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::{fs, iter};
use syn::visit::{self, Visit};

/// A module's path within its package; the crate's root is empty.
type Module = Vec<String>;

/// Files or top-level modules by what they import.
type Graph<N> = BTreeMap<N, BTreeSet<N>>;

#[test]
fn imports_form_no_cycles() {
    for folder in package_folders() {
        let imports = Sources::read(&folder.join("src")).imports();
        assert_eq!(cycles(&imports), [], "{}", folder.display());
        assert_eq!(cycles(&rooms(&imports)), [], "{}", folder.display());
    }
}

/// Each import of a script names its file by a path from its own folder.
#[test]
fn imports_of_the_page_form_no_cycles() {
    let src = root().join("node-viewer-bridge/page/src");
    let scripts = files_below(&src, "ts");
    assert!(scripts.len() > 50, "{scripts:?}");
    let imports = scripts.iter().map(|script| {
        let text = fs::read_to_string(script).expect("a script");
        let folder = script.parent().expect("a folder");
        let quoted = text.lines().filter_map(|line| {
            let (_, path) = line.split_once(" from \"")?;
            let path = path.trim_end_matches("\";");
            path.starts_with('.').then(|| folder.join(path))
        });
        let imported = quoted.map(|path| path.canonicalize().expect("a script"));
        (script.clone(), imported.collect())
    });
    assert_eq!(cycles(&imports.collect()), []);
}

/// Modules of the Python client import one another by `from .module import` and `from . import module`, also for types.
#[test]
fn imports_of_the_python_client_form_no_cycles() {
    let src = root().join("clients/python/src/sextant");
    let modules = files_below(&src, "py");
    assert!(modules.len() > 15, "{modules:?}");
    let imports = modules.iter().map(|module| {
        let text = fs::read_to_string(module).expect("a module");
        let lines = text.lines().map(str::trim_start);
        let imported = lines.filter_map(|line| {
            let (from, names) = line.strip_prefix("from .")?.split_once(" import ")?;
            let name = if from.is_empty() { names } else { from };
            let path = src.join(name).with_extension("py");
            path.is_file().then_some(path)
        });
        (module.clone(), imported.collect())
    });
    assert_eq!(cycles(&imports.collect()), []);
}

#[test]
fn a_cycle_through_a_re_export_is_found() {
    let sources = Sources::parse(&[
        ("", "mod a; mod b; pub use b::Item;"),
        ("a", "use crate::Item; pub struct Other;"),
        ("b", "mod inner; pub use inner::Item;"),
        ("b::inner", "pub struct Item(crate::a::Other);"),
        (
            "c",
            "use crate::a::Other; #[cfg(test)] mod tests { use super::*; }",
        ),
    ]);
    let module = |name: &str| name.split("::").map(str::to_owned).collect::<Module>();
    let cycle = BTreeSet::from([module("a"), module("b::inner")]);
    assert_eq!(cycles(&sources.imports()), [cycle]);
}

/// Every folder of the repository with a `Cargo.toml` and a `src`.
fn package_folders() -> Vec<PathBuf> {
    let groups = ["", "crates", "benches"].map(|group| root().join(group));
    let folders = groups.iter().flat_map(|group| entries(group));
    let packages: Vec<PathBuf> = folders
        .filter(|folder| folder.join("Cargo.toml").is_file() && folder.join("src").is_dir())
        .collect();
    assert!(packages.len() > 15, "{packages:?}");
    packages
}

fn root() -> PathBuf {
    let tests = Path::new(env!("CARGO_MANIFEST_DIR"));
    let root = tests.parent().expect("a parent");
    root.canonicalize().expect("a folder")
}

/// The files with this extension, those in folders below included.
fn files_below(folder: &Path, extension: &str) -> Vec<PathBuf> {
    let below = |path: PathBuf| match path.is_dir() {
        true => files_below(&path, extension),
        false => vec![path],
    };
    let files = entries(folder).into_iter().flat_map(below);
    files
        .filter(|file| file.extension().is_some_and(|it| it == extension))
        .collect()
}

fn entries(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).expect("a folder");
    let mut paths: Vec<PathBuf> = entries
        .map(|entry| entry.expect("an entry").path())
        .collect();
    paths.sort();
    paths
}

/// The parsed files of a package.
struct Sources {
    files: BTreeMap<Module, syn::File>,
    /// What the `use` items of each module bring in, by name, as absolute paths.
    aliases: BTreeMap<Module, BTreeMap<String, Module>>,
}

impl Sources {
    fn read(src: &Path) -> Self {
        let is_program = |path: &PathBuf| path.starts_with(src.join("bin"));
        let files = files_below(src, "rs").into_iter();
        let files = files.filter(|path| !is_program(path)).map(|path| {
            let text = fs::read_to_string(&path).expect("a source file");
            (module_of(src, &path), parsed(&text))
        });
        Self::new(files.collect())
    }

    fn parse(files: &[(&str, &str)]) -> Self {
        let module = |name: &str| {
            name.split("::")
                .filter(|part| !part.is_empty())
                .map(str::to_owned)
                .collect()
        };
        Self::new(
            files
                .iter()
                .map(|(name, text)| (module(name), parsed(text)))
                .collect(),
        )
    }

    fn new(files: BTreeMap<Module, syn::File>) -> Self {
        let modules: BTreeSet<&Module> = files.keys().collect();
        let aliases = files.iter().map(|(module, file)| {
            let uses = file.items.iter().filter_map(|item| match item {
                syn::Item::Use(item) => Some(item),
                _ => None,
            });
            let leaves = uses.flat_map(|item| leaves(&item.tree));
            let absolute = leaves.filter_map(|(path, name)| {
                let child = [module.as_slice(), &path[..1]].concat();
                let path = absolute(module, &path).or_else(|| {
                    let own = || [module.as_slice(), &path].concat();
                    modules.contains(&child).then(own)
                })?;
                Some((name, path))
            });
            (module.clone(), absolute.collect())
        });
        let aliases = aliases.collect();
        Self { files, aliases }
    }

    /// What each file imports from the package's other files.
    fn imports(&self) -> Graph<Module> {
        let of_file = |(module, file): (&Module, &syn::File)| {
            let mut paths = Paths {
                module: module.clone(),
                absolute: Vec::new(),
            };
            paths.visit_file(file);
            let imported = paths.absolute.iter().map(|path| self.file_with(path));
            let others = imported.filter(|other| other != module && !is_test(other));
            (module.clone(), others.collect())
        };
        let files = self.files.iter().filter(|(module, _)| !is_test(module));
        files.map(of_file).collect()
    }

    /// The file that has the item of an absolute path.
    fn file_with(&self, path: &[String]) -> Module {
        /// Re-exports of re-exports.
        const MOST_STEPS: usize = 8;
        let mut path = path.to_vec();
        for _ in 0..MOST_STEPS {
            let prefixes = (0..=path.len()).rev().map(|length| &path[..length]);
            let file = prefixes
                .into_iter()
                .find(|prefix| self.files.contains_key(*prefix));
            let file = file.unwrap_or_default().to_vec();
            let name = path.get(file.len());
            let Some(alias) = name.and_then(|name| self.aliases.get(&file)?.get(name)) else {
                return file;
            };
            path = [alias.as_slice(), &path[file.len() + 1..]].concat();
        }
        Module::new()
    }
}

fn parsed(text: &str) -> syn::File {
    syn::parse_file(text).expect("Rust")
}

fn module_of(src: &Path, file: &Path) -> Module {
    let path = file
        .strip_prefix(src)
        .expect("below src")
        .with_extension("");
    let parts = path.iter().map(|part| part.to_string_lossy().into_owned());
    parts
        .filter(|part| !["lib", "main", "mod"].contains(&part.as_str()))
        .collect()
}

fn is_test(module: &Module) -> bool {
    module
        .iter()
        .any(|part| part == "tests" || part.ends_with("_tests"))
}

/// The absolute path of one that begins with `crate`, `self` or `super`, as seen from a module.
fn absolute(module: &Module, path: &[String]) -> Option<Module> {
    let ups = path.iter().take_while(|part| *part == "super").count();
    match path.first()?.as_str() {
        "crate" => Some(path[1..].to_vec()),
        "self" => Some([module.as_slice(), &path[1..]].concat()),
        "super" => Some([module.get(..module.len().checked_sub(ups)?)?, &path[ups..]].concat()),
        _ => None,
    }
}

/// The paths of a `use` tree with the names that they bring in.
fn leaves(tree: &syn::UseTree) -> Vec<(Module, String)> {
    match tree {
        syn::UseTree::Path(path) => {
            let below = leaves(&path.tree).into_iter();
            let whole = |below| iter::once(path.ident.to_string()).chain(below).collect();
            below
                .map(|(below, name): (Module, _)| (whole(below), name))
                .collect()
        }
        syn::UseTree::Group(group) => group.items.iter().flat_map(leaves).collect(),
        syn::UseTree::Name(name) => vec![(vec![name.ident.to_string()], name.ident.to_string())],
        syn::UseTree::Rename(name) => vec![(vec![name.ident.to_string()], name.rename.to_string())],
        syn::UseTree::Glob(_) => vec![(Vec::new(), "*".to_owned())],
    }
}

/// Collects the absolute form of all paths of a file that begin with `crate` or `super`.
struct Paths {
    module: Module,
    absolute: Vec<Module>,
}

impl Paths {
    fn take(&mut self, path: &[String]) {
        if path.first().is_some_and(|first| first != "self") {
            self.absolute.extend(absolute(&self.module, path));
        }
    }
}

impl Visit<'_> for Paths {
    fn visit_item_use(&mut self, item: &syn::ItemUse) {
        for (path, _) in leaves(&item.tree) {
            self.take(&path);
        }
    }

    fn visit_path(&mut self, path: &syn::Path) {
        let parts: Module = path
            .segments
            .iter()
            .map(|part| part.ident.to_string())
            .collect();
        self.take(&parts);
        visit::visit_path(self, path);
    }

    fn visit_visibility(&mut self, _: &syn::Visibility) {}

    fn visit_item_mod(&mut self, item: &syn::ItemMod) {
        if !item.attrs.iter().any(is_for_tests) {
            self.module.push(item.ident.to_string());
            visit::visit_item_mod(self, item);
            self.module.pop();
        }
    }
}

fn is_for_tests(attribute: &syn::Attribute) -> bool {
    let condition = attribute
        .path()
        .is_ident("cfg")
        .then(|| attribute.parse_args::<syn::Path>().ok());
    condition
        .flatten()
        .is_some_and(|path| path.is_ident("test"))
}

/// The same between top-level modules; the crate's root is none.
fn rooms(files: &Graph<Module>) -> Graph<String> {
    let mut rooms = Graph::new();
    for (file, imported) in files {
        let Some(room) = file.first() else { continue };
        let others = imported.iter().filter_map(|other| other.first());
        let others = others.filter(|other| *other != room).cloned();
        rooms
            .entry(room.clone())
            .or_insert_with(BTreeSet::new)
            .extend(others);
    }
    rooms
}

/// The sets of nodes that reach one another.
fn cycles<N: Clone + Ord>(graph: &Graph<N>) -> Vec<BTreeSet<N>> {
    let reached: Graph<N> = graph
        .keys()
        .map(|node| (node.clone(), reachable(graph, node)))
        .collect();
    let cycle = |(node, reached_by_node): (&N, &BTreeSet<N>)| -> Option<BTreeSet<N>> {
        let back = |other: &&N| reached.get(*other).is_some_and(|set| set.contains(node));
        let cycle: BTreeSet<N> = reached_by_node.iter().filter(back).cloned().collect();
        (!cycle.is_empty()).then_some(cycle)
    };
    let cycles: BTreeSet<BTreeSet<N>> = reached.iter().filter_map(cycle).collect();
    cycles.into_iter().collect()
}

/// What a node leads to in one step or more.
fn reachable<N: Clone + Ord>(graph: &Graph<N>, from: &N) -> BTreeSet<N> {
    let (mut reached, mut open) = (BTreeSet::new(), vec![from]);
    while let Some(node) = open.pop() {
        for next in graph.get(node).into_iter().flatten() {
            if reached.insert(next.clone()) {
                open.push(next);
            }
        }
    }
    reached
}
