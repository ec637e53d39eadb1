//! Tests that need more of the machine than others.

use crate::list::{
    CHROMIUM, DPKG_DEB, FFMPEG, IP, NAME_SPACES, NODE, OVERLAYFS, SSHD, USER_NAME_SPACES,
};
use crate::need::Need;
use crate::skips::{is_ci, note_skip};

/// A test that is skipped where the machine lacks something.
#[derive(Debug)]
pub struct Guarded {
    /// The test function.
    pub test: &'static str,
    /// What it needs.
    pub needs: &'static [&'static Need],
}

pub const FLEET: Guarded = Guarded {
    test: "hosts_of_a_fleet_are_new_or_as_they_were",
    needs: &[&NAME_SPACES, &OVERLAYFS, &SSHD, &DPKG_DEB, &IP],
};
pub const HOSTS: Guarded = Guarded {
    test: "a_site_of_several_hosts_loses_one_and_goes_on",
    needs: &[&NAME_SPACES, &IP],
};
pub const NO_SHARED_MEMORY: Guarded = Guarded {
    test: "a_camera_out_of_shared_memory_says_so_and_recovers",
    needs: &[&NAME_SPACES],
};
pub const DISK_FULL: Guarded = Guarded {
    test: "a_recorder_whose_disk_is_full_says_so_and_keeps_what_it_has",
    needs: &[&NAME_SPACES],
};
pub const FORMER_VERSIONS: Guarded = Guarded {
    test: "refused_changes_on_a_full_disk_cost_no_former_version",
    needs: &[&NAME_SPACES],
};
pub const UNITS: Guarded = Guarded {
    test: "every_unit_does_its_work_within_its_sandbox",
    needs: &[&USER_NAME_SPACES],
};
pub const PAGE: Guarded = Guarded {
    test: "objects_move_outlines_are_drawn_and_the_page_reconnects",
    needs: BROWSER,
};
pub const PLAY: Guarded = Guarded {
    test: "the_last_seconds_of_a_site_are_saved_and_played_on_the_page",
    needs: BROWSER,
};
pub const WIZARDS: Guarded = Guarded {
    test: "a_lens_a_rig_and_an_object_are_calibrated_from_the_page",
    needs: BROWSER,
};
pub const FAULTS: Guarded = Guarded {
    test: "wrong_tags_are_named_in_the_status_on_the_page_and_in_top",
    needs: BROWSER,
};
pub const VIDEO: Guarded = Guarded {
    test: "a_video_is_played_at_its_own_times_to_its_end",
    needs: &[&FFMPEG],
};
pub const WEB: Guarded = Guarded {
    test: "web_assembly_finds_the_same_tags",
    needs: &[&NODE],
};
pub const PHONE: Guarded = Guarded {
    test: "a_browser_is_a_camera_of_the_site",
    needs: BROWSER,
};
const BROWSER: &[&Need] = &[&NODE, &CHROMIUM];

/// All tests that need more of the machine.
pub const GUARDED: &[&Guarded] = &[
    &FLEET,
    &HOSTS,
    &NO_SHARED_MEMORY,
    &DISK_FULL,
    &FORMER_VERSIONS,
    &UNITS,
    &PAGE,
    &PLAY,
    &WIZARDS,
    &FAULTS,
    &VIDEO,
    &WEB,
    &PHONE,
];

impl Guarded {
    /// What the machine lacks first, and what to do about it.
    #[must_use]
    pub fn lack(&self) -> Option<String> {
        let unmet = self.needs.iter().find(|need| !need.is_met());
        unmet.map(|need| need.lack())
    }

    /// Whether the test has to end at once. It is said why, and noted for the end of `cargo xtask test`.
    ///
    /// # Panics
    /// In continuous integration, instead of a skip.
    #[must_use]
    pub fn is_skipped(&self) -> bool {
        let Some(lack) = self.lack() else {
            return false;
        };
        assert!(!is_ci(), "{}: {lack}", self.test);
        note_skip(self.test, &lack);
        true
    }
}
