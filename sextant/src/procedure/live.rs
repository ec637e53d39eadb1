//! Images of a running site: the observations that the fusion node gets, until there are enough or Ctrl-C.

use super::ImageSelection;
use super::progress_display::ProgressDisplay;
use crate::output::Format;
use crate::site::report_router;
use anyhow::{anyhow, bail};
use sextant_calibrator::procedure::{Procedure, ProcedureOutcome};
use sextant_gateways::site::{RouterWatch, SiteSession, take};
use sextant_process::shutdown::SHUTDOWN_POLL;
use sextant_process::{Exit, Failure, WithExit, monotonic_ns};
use sextant_proto::{AnyMessage, limits};
use sextant_site_mirror::SiteMirror;
use sextant_site_mirror::limits::SILENCE_NS;
use sextant_site_model::{CameraId, ImageObservation};
use sextant_zenoh_bus::{DropRule, Subscription};

/// Most queued messages while a display is drawn or a solution computed; the oldest are dropped.
const QUEUE: usize = 2048;
/// Growth of the number of images before another attempt after a failed solution.
const MORE_IMAGES: f64 = 1.3;

/// Images of a running site.
pub struct Live {
    site: SiteSession,
    messages: Subscription,
    router: RouterWatch,
    teller: ProgressDisplay,
    mirror: SiteMirror,
    /// When it began to listen, by the monotonic clock.
    since_ns: u64,
}

impl Live {
    /// Subscribes to every camera of a site.
    ///
    /// # Errors
    /// A failed subscription.
    pub fn open(site: SiteSession, format: Format) -> anyhow::Result<Self> {
        let messages = site.bus.subscribe(
            &site.keys.all_observations(),
            QUEUE,
            DropRule::Oldest,
            limits::MAX_PAYLOAD_BYTES,
        )?;
        Ok(Self {
            site,
            messages,
            router: RouterWatch::default(),
            teller: ProgressDisplay::new(format),
            mirror: SiteMirror::default(),
            since_ns: monotonic_ns(),
        })
    }

    /// Waits for the first image of a camera and returns its resolution, width and height.
    ///
    /// # Errors
    /// [`Exit::Interrupted`] if it is stopped before.
    pub fn resolution_of(&mut self, camera: &CameraId) -> anyhow::Result<[u32; 2]> {
        while !self.site.shutdown.is_requested() {
            self.next();
            let known = self.mirror.camera(camera);
            if let Some(resolution) = known.and_then(|camera| camera.resolution) {
                return Ok(resolution);
            }
            if monotonic_ns() - self.since_ns > SILENCE_NS {
                self.teller.remark(&self.silence(camera));
            }
            report_router(&mut self.router, &self.site.bus);
        }
        bail!(interrupted(self.silence(camera)))
    }

    /// Handles images until there are enough or Ctrl-C, and solves; Ctrl-C during the solution gives up. If the images
    /// are not sufficient yet, it reports that and continues.
    ///
    /// # Errors
    /// [`Exit::Interrupted`] for Ctrl-C before any detection, [`Exit::Input`] if the images give no result.
    pub fn outcome(
        mut self,
        mut procedure: Procedure,
        looking: &ImageSelection,
    ) -> anyhow::Result<ProcedureOutcome> {
        let mut least_images = 0;
        loop {
            self.collect(&mut procedure, looking, least_images)?;
            let images = procedure.progress().images;
            if images == 0 {
                let left_out = procedure.left_out();
                let left_out: Vec<String> = left_out.iter().map(ToString::to_string).collect();
                let words = match &left_out[..] {
                    [] => "ended before any image came".to_owned(),
                    all => format!("ended before any image was used: {}", all.join("; ")),
                };
                bail!(interrupted(words));
            }
            self.teller.say("solving ...")?;
            let solved = self.site.shutdown.interruptible(|| procedure.solve());
            let missing = match &solved {
                Ok(outcome) => outcome.unsolved().join("; "),
                Err(cause) => cause.to_string(),
            };
            if missing.is_empty() || self.site.shutdown.is_requested() {
                self.site.bus.close();
                return solved.exit_with(Exit::Input);
            }
            self.teller.say(&format!("not yet: {missing}"))?;
            least_images = (images as f64 * MORE_IMAGES) as usize;
        }
    }

    /// Runs until there are enough images, at least this many, or Ctrl-C.
    fn collect(
        &mut self,
        procedure: &mut Procedure,
        looking: &ImageSelection,
        least_images: usize,
    ) -> anyhow::Result<()> {
        while !self.site.shutdown.is_requested() {
            if let Some(image) = self.next() {
                procedure.handle(&image).exit_with(Exit::Input)?;
            }
            if self.teller.is_due() {
                let progress = procedure.progress();
                let remarks = self.remarks(procedure, looking);
                self.teller.show(&progress, &remarks)?;
                if progress.is_enough && progress.images >= least_images {
                    return Ok(());
                }
            }
        }
        Ok(())
    }

    /// The next image, if one arrives soon; invalid messages are ignored.
    fn next(&mut self) -> Option<ImageObservation> {
        let item = self.messages.recv_timeout(SHUTDOWN_POLL)?;
        let update = take(&self.site.keys, &mut self.mirror, &item, monotonic_ns())?;
        let AnyMessage::Observations(message) = update.message else {
            return None;
        };
        Some(ImageObservation::from(&message))
    }

    /// Remarks on the network and the cameras.
    fn remarks(&mut self, procedure: &Procedure, looking: &ImageSelection) -> Vec<String> {
        if self.router.silent_s(&self.site.bus).is_some() {
            return vec!["the router does not answer; waiting for it".to_owned()];
        }
        let known = looking.rig.cameras().iter().map(|camera| &camera.id);
        let silent = known.filter(|id| procedure.counts(id)).filter(|id| {
            let camera = self.mirror.camera(id).cloned().unwrap_or_default();
            camera.lacks_images(self.since_ns, monotonic_ns())
        });
        let mut remarks: Vec<String> = silent
            .map(|id| format!("camera {id} sends nothing; does it run, and is this its name?"))
            .collect();
        let strangers = self.mirror.cameras().map(|(id, _)| id);
        let strangers = strangers.filter(|id| looking.rig.camera(id).is_none());
        // A procedure with one camera ignores the others.
        if looking.cameras.is_empty() {
            remarks.extend(strangers.map(|id| {
                format!("camera {id} is not in the rig file: `sextant calibrate lens` adds it")
            }));
        }
        remarks
    }

    fn silence(&self, camera: &CameraId) -> String {
        let others = self.mirror.cameras().map(|(id, _)| id.as_str());
        let others: Vec<&str> = others.collect();
        let others = if others.is_empty() {
            "nor does any other camera of this site".to_owned()
        } else {
            format!("but these do: {}", others.join(", "))
        };
        format!("camera {camera} sends nothing, {others}")
    }
}

fn interrupted(cause: String) -> Failure {
    Failure::new(Exit::Interrupted, anyhow!(cause))
}
