//! An allocator with a limit, for every fuzz target: no foreign bytes may make a decoder ask for more.

use std::alloc::{GlobalAlloc, Layout, System};

/// The largest single allocation: a picture of the largest size that is read.
const MOST_BYTES: usize = 400 << 20;

/// The system's allocator; it ends the process when more than 400 MiB is asked for at once.
pub struct Limited;

fn check(bytes: usize) {
    if bytes > MOST_BYTES {
        // No message: that would allocate.
        std::process::abort();
    }
}

// SAFETY: every call goes to the system's allocator unchanged.
unsafe impl GlobalAlloc for Limited {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        check(layout.size());
        // SAFETY: the caller's promise is passed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        check(layout.size());
        // SAFETY: the caller's promise is passed on.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        check(size);
        // SAFETY: the caller's promise is passed on.
        unsafe { System.realloc(memory, layout, size) }
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        // SAFETY: the caller's promise is passed on.
        unsafe { System.dealloc(memory, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Limited = Limited;
