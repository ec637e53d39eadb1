//! Nothing that runs for every image touches the heap.

#![allow(clippy::unwrap_used, reason = "tests")]

use nalgebra::{Point2, Point3};
use sextant_geometry::planar_pose::solve_square;
use sextant_geometry::{Homography, Intrinsics, Lens, tag_corners_in_tag};
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

/// The system's allocator, which counts each thread's allocations.
struct Counting;

thread_local! {
    static N_ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
}

// SAFETY: every call is passed on to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        N_ALLOCATIONS.set(N_ALLOCATIONS.get() + 1);
        // SAFETY: the caller keeps the contract of `alloc`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: `pointer` came from `alloc` above, that is from the system's allocator.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn allocations_of<T>(f: impl FnOnce() -> T) -> usize {
    let before = N_ALLOCATIONS.get();
    std::hint::black_box(f());
    N_ALLOCATIONS.get() - before
}

#[test]
fn an_allocation_is_counted() {
    assert_eq!(allocations_of(|| vec![1, 2, 3]), 1);
}

#[test]
fn lenses_homographies_and_poses_allocate_nothing() {
    let intrinsics = Intrinsics {
        fx: 600.0,
        fy: 600.0,
        cx: 319.5,
        cy: 239.5,
    };
    let corners = [
        [280.0, 200.0],
        [350.0, 210.0],
        [340.0, 280.0],
        [275.0, 270.0],
    ]
    .map(Point2::from);
    let face = tag_corners_in_tag(0.1).map(|corner| corner.xy());
    let lenses = [
        Lens::pinhole(intrinsics).unwrap(),
        Lens::brown_conrady(intrinsics, [-0.2, 0.05, 1e-3, -1e-3, 0.0]).unwrap(),
        Lens::kannala_brandt(intrinsics, [0.02, -0.01, 0.0, 0.0]).unwrap(),
    ];
    for lens in lenses {
        assert_eq!(
            allocations_of(|| solve_square(&lens, &corners, 0.1).unwrap()),
            0
        );
        assert_eq!(allocations_of(|| lens.unproject(&corners[0]).unwrap()), 0);
        assert_eq!(
            allocations_of(|| lens
                .parameter_jacobian(&Point3::new(0.1, 0.2, 1.0))
                .unwrap()),
            0
        );
    }
    assert_eq!(
        allocations_of(|| Homography::from_corners(&face, &corners).unwrap()),
        0
    );
}
