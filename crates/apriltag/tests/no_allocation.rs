//! After it has seen an image of a size, the detector takes nothing more from the heap.

mod drawing;

use drawing::{Camera, Picture, Tag};
use sextant_apriltag::{Detector, Image, Options};
use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};

struct Counting;

static ALLOCATIONS: AtomicUsize = AtomicUsize::new(0);

// SAFETY: every call goes on to the system's allocator as it came; counting touches no memory of the caller's.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::Relaxed);
        // SAFETY: the caller keeps the contract of `alloc`, which is the same.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: `pointer` came from `System` through `alloc` or `realloc`.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, new_size: usize) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::Relaxed);
        // SAFETY: `pointer` came from `System` through `alloc` or `realloc`.
        unsafe { System.realloc(pointer, layout, new_size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn a_seen_size_needs_no_more_memory_whatever_the_image_shows() {
    let camera = Camera::new(320, 240);
    let at = |id, x, y| Tag {
        position_m: [x, y, 0.7],
        turn_deg: [20.0, 10.0, 30.0],
        ..Tag::new(id)
    };
    let tags = [
        at(1, -0.1, -0.05),
        at(2, 0.0, -0.05),
        at(3, 0.1, -0.05),
        at(4, -0.1, 0.05),
        at(5, 0.1, 0.05),
    ];
    let empty = vec![128; camera.width * camera.height];
    let tagged = Picture::draw(&camera, &tags, 128.0)
        .blurred(0.5)
        .pixels(2.0, 1);
    let noisy = Picture::draw(&camera, &tags, 128.0)
        .blurred(0.5)
        .pixels(60.0, 2);

    let mut detector = Detector::new(Options::default()).unwrap();
    let mut allocations = |pixels: &[u8]| {
        let image = Image::new(pixels, camera.width, camera.height, camera.width).unwrap();
        let before = ALLOCATIONS.load(Ordering::Relaxed);
        let n_tags = detector.detect(&image).len();
        (n_tags, ALLOCATIONS.load(Ordering::Relaxed) - before)
    };
    allocations(&empty);
    for (pixels, n_tags) in [(&tagged, 5), (&empty, 0), (&tagged, 5)] {
        assert_eq!(allocations(pixels), (n_tags, 0));
    }
    assert_eq!(allocations(&noisy).1, 0);
}
