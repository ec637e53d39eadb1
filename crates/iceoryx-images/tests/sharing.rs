//! Images between threads and processes: the newest wins, nobody waits for a slow or dead reader, and nothing remains.
//!
//! A child process is this test binary again, run with the one ignored test `child` and a role in the environment.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test fails by panicking"
)]

use std::fs;
use std::io::{BufRead, BufReader};
use std::os::unix::fs::{chown, symlink};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant};

use sextant_iceoryx_images::{
    IceoryxOptions, ImageHeader, ImagePublisher, ImageSubscriber, ImagesError, Leftovers,
    MAX_SUBSCRIBERS, remove_dead,
};

const PATIENCE: Duration = Duration::from_secs(60);
const WIDTH: u16 = 640;
const HEIGHT: u16 = 480;
const BYTES: usize = WIDTH as usize * HEIGHT as usize;

/// A meeting place of its own for each test; asserts on drop that nothing of it remains.
struct Place {
    options: IceoryxOptions,
    folder: tempfile::TempDir,
}

impl Place {
    fn new() -> Self {
        static NUMBER: AtomicU32 = AtomicU32::new(0);
        let folder = tempfile::Builder::new()
            .prefix("sxi")
            .tempdir_in("/tmp")
            .unwrap();
        let number = NUMBER.fetch_add(1, Ordering::SeqCst);
        let prefix = format!("{:x}-{number}", std::process::id());
        Self {
            options: IceoryxOptions {
                root: folder.path().join("i"),
                prefix,
            },
            folder,
        }
    }

    fn shared_memory_files(&self) -> Vec<(PathBuf, u64)> {
        let start = format!("{}_", self.options.prefix);
        let is_ours = |path: &PathBuf| {
            path.file_name()
                .unwrap()
                .to_string_lossy()
                .starts_with(&start)
        };
        let files = fs::read_dir("/dev/shm")
            .unwrap()
            .map(|entry| entry.unwrap().path())
            .filter(is_ours);
        files
            .map(|path| {
                (
                    path.clone(),
                    fs::metadata(&path).map_or(0, |file| file.len()),
                )
            })
            .collect()
    }

    fn assert_nothing_remains(&self) {
        assert_eq!(self.shared_memory_files(), []);
        assert!(
            !self.options.root.exists(),
            "{:?}",
            fs::read_dir(&self.options.root)
                .unwrap()
                .collect::<Vec<_>>()
        );
        assert!(self.folder.path().exists());
    }

    fn publisher(&self) -> ImagePublisher {
        ImagePublisher::open(&self.options, "north", BYTES).unwrap()
    }

    fn subscriber(&self) -> ImageSubscriber {
        ImageSubscriber::open(&self.options, "north").unwrap()
    }

    /// A child with a role; returns when it says that it is ready.
    fn child(&self, role: &str) -> Child {
        let mut child = Command::new(std::env::current_exe().unwrap())
            .args(["--exact", "child", "--ignored", "--nocapture"])
            .env("ROLE", role)
            .env("PLACE_ROOT", &self.options.root)
            .env("PLACE_PREFIX", &self.options.prefix)
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let lines = BufReader::new(child.stdout.take().unwrap()).lines();
        assert!(
            lines.map(Result::unwrap).any(|line| line.contains("ready")),
            "{role} ended early"
        );
        child
    }
}

fn kill(mut child: Child) {
    child.kill().unwrap();
    child.wait().unwrap();
}

/// Lends an image whose pixels all have the value of its sequence number.
fn lend(publisher: &ImagePublisher, sequence: u64) {
    let mut image = publisher.blank(BYTES).unwrap();
    let (header, pixels) = image.parts();
    *header = ImageHeader {
        sequence,
        width: WIDTH,
        height: HEIGHT,
        stride: u32::from(WIDTH),
        ..ImageHeader::default()
    };
    pixels.fill(sequence as u8);
    publisher.send(image).unwrap();
}

fn take(subscriber: &mut ImageSubscriber) -> u64 {
    let image = subscriber
        .wait(PATIENCE)
        .unwrap()
        .expect("an image within a minute");
    let sequence = image.header().sequence;
    assert_eq!(image.pixels().len(), BYTES);
    assert!(
        image.pixels().iter().all(|pixel| *pixel == sequence as u8),
        "a torn image"
    );
    sequence
}

/// Lends until the subscriber sees something: a child's subscriber connects some time after both exist.
fn lend_until_taken(
    publisher: &ImagePublisher,
    subscriber: &mut ImageSubscriber,
    first: u64,
) -> u64 {
    let deadline = Instant::now() + PATIENCE;
    for sequence in first.. {
        lend(publisher, sequence);
        if subscriber
            .wait(Duration::from_millis(20))
            .unwrap()
            .is_some()
        {
            return sequence;
        }
        assert!(Instant::now() < deadline, "never connected");
    }
    unreachable!()
}

#[test]
#[ignore = "a role of the other tests"]
fn child() {
    let Ok(role) = std::env::var("ROLE") else {
        return;
    };
    let root = std::env::var_os("PLACE_ROOT").unwrap().into();
    let options = IceoryxOptions {
        root,
        prefix: std::env::var("PLACE_PREFIX").unwrap(),
    };
    match role.as_str() {
        "lender" => {
            let publisher = ImagePublisher::open(&options, "north", BYTES).unwrap();
            for sequence in 0.. {
                lend(&publisher, sequence);
                if sequence == 0 {
                    println!("ready");
                }
                std::thread::sleep(Duration::from_millis(5));
            }
        }
        "half-lender" => {
            let publisher = ImagePublisher::open(&options, "north", BYTES).unwrap();
            let _never_sent = publisher.blank(BYTES).unwrap();
            println!("ready");
            std::thread::sleep(PATIENCE);
        }
        "reader" => {
            let mut subscriber = ImageSubscriber::open(&options, "north").unwrap();
            println!("ready");
            let _held = subscriber.wait(PATIENCE).unwrap();
            std::thread::sleep(PATIENCE);
        }
        other => panic!("no role {other}"),
    }
}

#[test]
fn an_image_arrives_as_it_was_filled() {
    let place = Place::new();
    {
        let (publisher, mut subscriber) = (place.publisher(), place.subscriber());
        lend(&publisher, 7);
        assert_eq!(take(&mut subscriber), 7);
        assert!(subscriber.wait(Duration::ZERO).unwrap().is_none());
    }
    place.assert_nothing_remains();
}

#[test]
fn a_slow_reader_gets_the_newest_and_delays_nobody() {
    let place = Place::new();
    let publisher = place.publisher();
    let (mut slow, mut fast) = (place.subscriber(), place.subscriber());
    lend(&publisher, 0);
    let held = slow.wait(PATIENCE).unwrap().unwrap();
    for sequence in 1..300 {
        lend(&publisher, sequence);
        assert_eq!(take(&mut fast), sequence);
    }
    assert!(
        held.pixels().iter().all(|pixel| *pixel == 0),
        "a held image was written to"
    );
    drop(held);
    assert_eq!(take(&mut slow), 299);
}

#[test]
fn a_waiting_reader_is_woken() {
    let place = Place::new();
    let publisher = place.publisher();
    let options = place.options.clone();
    let (ready, is_ready) = std::sync::mpsc::channel();
    let reader = std::thread::spawn(move || {
        let mut subscriber = ImageSubscriber::open(&options, "north").unwrap();
        ready.send(()).unwrap();
        take(&mut subscriber)
    });
    is_ready.recv().unwrap();
    lend(&publisher, 3);
    assert_eq!(reader.join().unwrap(), 3);
}

#[test]
fn four_readers_cost_less_than_six_megabytes_and_a_fifth_is_refused() {
    let place = Place::new();
    {
        let publisher = place.publisher();
        let mut readers: Vec<_> = (0..MAX_SUBSCRIBERS).map(|_| place.subscriber()).collect();
        lend(&publisher, 1);
        readers
            .iter_mut()
            .for_each(|reader| assert_eq!(take(reader), 1));
        let bytes: u64 = place
            .shared_memory_files()
            .iter()
            .map(|(_, bytes)| bytes)
            .sum();
        println!("shared memory of a camera with four readers: {bytes} bytes");
        assert!(bytes < 6_000_000, "{bytes}");
        let fifth = ImageSubscriber::open(&place.options, "north").unwrap_err();
        assert!(matches!(fifth, ImagesError::Full { .. }), "{fifth}");
        drop(readers.pop());
        place.subscriber();
    }
    place.assert_nothing_remains();
}

#[test]
fn a_second_lender_is_refused_by_name() {
    let place = Place::new();
    let _publisher = place.publisher();
    let second = ImagePublisher::open(&place.options, "north", BYTES).unwrap_err();
    assert!(matches!(second, ImagesError::InUse { .. }), "{second}");
    ImagePublisher::open(&place.options, "south", BYTES).unwrap();
}

#[test]
fn an_image_of_another_process_arrives() {
    let place = Place::new();
    let lender = place.child("lender");
    let mut subscriber = place.subscriber();
    let first = take(&mut subscriber);
    assert!(take(&mut subscriber) > first);
    kill(lender);
    drop(subscriber);
    remove_dead(&place.options).unwrap();
    place.assert_nothing_remains();
}

#[test]
fn a_killed_lender_is_succeeded_and_its_readers_go_on() {
    let place = Place::new();
    let mut subscriber = place.subscriber();
    for role in ["lender", "half-lender"] {
        let lender = place.child(role);
        if role == "lender" {
            take(&mut subscriber);
        }
        kill(lender);
    }
    {
        // Another image size as well, as after a change of the configuration.
        let publisher = ImagePublisher::open(&place.options, "north", 2 * BYTES).unwrap();
        lend_until_taken(&publisher, &mut subscriber, 100);
        drop(subscriber);
    }
    place.assert_nothing_remains();
}

#[test]
fn killed_readers_free_their_places() {
    let place = Place::new();
    {
        let publisher = place.publisher();
        let children: Vec<_> = (0..MAX_SUBSCRIBERS)
            .map(|_| place.child("reader"))
            .collect();
        (0..50).for_each(|sequence| lend(&publisher, sequence));
        children.into_iter().for_each(kill);
        (50..100).for_each(|sequence| lend(&publisher, sequence));
        let mut readers: Vec<_> = (0..MAX_SUBSCRIBERS).map(|_| place.subscriber()).collect();
        for (number, reader) in readers.iter_mut().enumerate() {
            lend_until_taken(&publisher, reader, 100 + 1000 * number as u64);
        }
    }
    place.assert_nothing_remains();
}

#[test]
fn leftovers_of_killed_processes_are_removed_on_request() {
    let place = Place::new();
    let lender = place.child("lender");
    let reader = place.child("reader");
    assert_eq!(remove_dead(&place.options).unwrap().alive, 2);
    kill(lender);
    kill(reader);
    assert!(!place.shared_memory_files().is_empty());
    let found = remove_dead(&place.options).unwrap();
    assert_eq!((found.alive, found.removed, found.failed), (0, 2, 0));
    place.assert_nothing_remains();
    assert_eq!(remove_dead(&place.options).unwrap(), Leftovers::default());
}

#[test]
fn another_place_is_not_touched() {
    let (here, there) = (Place::new(), Place::new());
    let publisher = here.publisher();
    let mut elsewhere = there.subscriber();
    lend(&publisher, 1);
    assert!(elsewhere.wait(Duration::from_millis(20)).unwrap().is_none());
    remove_dead(&there.options).unwrap();
    drop(elsewhere);
    there.assert_nothing_remains();
    let mut subscriber = here.subscriber();
    lend(&publisher, 2);
    assert_eq!(take(&mut subscriber), 2);
}

#[test]
fn a_site_that_closes_leaves_another_in_the_same_root_as_it_is() {
    let (here, mut there) = (Place::new(), Place::new());
    there.options.root.clone_from(&here.options.root);
    let publisher = here.publisher();
    let files = files_below(&here.options.root);
    drop(there.publisher());
    kill(there.child("lender"));
    assert_eq!(remove_dead(&there.options).unwrap().removed, 1);
    assert_eq!(there.shared_memory_files(), []);
    assert_eq!(files_below(&here.options.root), files);
    let mut subscriber = here.subscriber();
    lend(&publisher, 1);
    assert_eq!(take(&mut subscriber), 1);
    drop((publisher, subscriber));
    here.assert_nothing_remains();
}

/// Paths of everything in a folder, sorted.
fn files_below(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap().map(Result::unwrap) {
        if entry.file_type().unwrap().is_dir() {
            found.extend(files_below(&entry.path()));
        }
        found.push(entry.path());
    }
    found.sort();
    found
}

#[test]
fn nothing_behind_a_planted_link_is_removed() {
    let place = Place::new();
    let precious = place.folder.path().join("precious");
    let file = precious.join("1/thesis.txt");
    fs::create_dir_all(file.parent().unwrap()).unwrap();
    fs::write(&file, "years").unwrap();
    let nodes = place.options.root.join("nodes");

    fs::create_dir_all(&nodes).unwrap();
    let planted = nodes.join("1");
    symlink(file.parent().unwrap(), &planted).unwrap();
    drop(place.publisher());
    remove_dead(&place.options).unwrap();
    assert!(fs::symlink_metadata(&planted).is_ok() && file.exists());

    fs::remove_dir_all(&nodes).unwrap();
    symlink(&precious, &nodes).unwrap();
    let refusal = remove_dead(&place.options).unwrap_err();
    assert!(matches!(refusal, ImagesError::Root { .. }), "{refusal}");
    assert!(ImagePublisher::open(&place.options, "north", BYTES).is_err());
    assert!(fs::symlink_metadata(&nodes).is_ok() && file.exists());

    fs::remove_dir_all(&place.options.root).unwrap();
    symlink(&precious, &place.options.root).unwrap();
    assert!(ImagePublisher::open(&place.options, "north", BYTES).is_err());
    assert!(fs::symlink_metadata(&place.options.root).is_ok() && file.exists());
}

/// Only the superuser can give a folder away; as anybody else this looks at the root's own.
#[test]
fn another_users_folder_is_refused() {
    let mut place = Place::new();
    fs::create_dir(&place.options.root).unwrap();
    if chown(&place.options.root, Some(12_345), None).is_err() {
        place.options.root = "/proc/1".into();
    }
    let refusal = ImagePublisher::open(&place.options, "north", BYTES).unwrap_err();
    assert!(refusal.to_string().contains("belongs to user"), "{refusal}");
}

#[test]
fn opening_and_closing_at_the_same_time_never_fails() {
    let place = Place::new();
    let threads: Vec<_> = (0..3)
        .map(|_| {
            let options = place.options.clone();
            std::thread::spawn(move || {
                for _ in 0..15 {
                    ImageSubscriber::open(&options, "north").unwrap();
                }
            })
        })
        .collect();
    threads
        .into_iter()
        .for_each(|thread| thread.join().unwrap());
    place.assert_nothing_remains();
}
