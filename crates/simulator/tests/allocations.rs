//! After the first images a renderer takes no memory from the heap.

#![allow(clippy::unwrap_used, reason = "a test may end in a panic")]

use sextant_simulator::{Renderer, Scenario};
use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};

struct Counting;

static TAKEN: AtomicUsize = AtomicUsize::new(0);

// SAFETY: every call is handed to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        TAKEN.fetch_add(1, Ordering::Relaxed);
        // SAFETY: the caller keeps the contract of `alloc`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the caller keeps the contract of `dealloc`.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn an_image_takes_no_memory_from_the_heap() {
    let mut renderer = Renderer::new(&Scenario::demo(4, 6, 1), 0).unwrap();
    let mut image = vec![0; 640 * 480];
    renderer.render(0, &mut image).unwrap();
    let before = TAKEN.load(Ordering::Relaxed);
    for n in 1..40 {
        renderer.render(n * 200_000_000, &mut image).unwrap();
    }
    assert_eq!(TAKEN.load(Ordering::Relaxed), before);
}
