//! The interface of the wizards to network and server: requests, images and answers go into the queue of the wizard's
//! thread, changes come out for the network. Nobody waits here for the thread.

use super::command::Command;
use super::inbox::Inbox;
use super::wizard_core::{Input, Reply, RequestInput, UserRequest};
use crate::changes::{Offer, Outgoing};
use crate::refusal::Refusal;
use sextant_proto::{ConfigAnswer, NodeId, Proposal};
use sextant_site_files::read_rig;
use sextant_site_mirror::SiteMirror;
use sextant_site_model::{ImageObservation, Rig};
use std::collections::VecDeque;
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};
use tokio::sync::oneshot;

/// One for the whole bridge.
#[derive(Debug)]
pub(crate) struct WizardService {
    /// Where results are kept.
    folder: Option<PathBuf>,
    inbox: Inbox,
    /// Changes that the network's thread has not published yet: the machine makes one after the other.
    outgoing: Mutex<VecDeque<Outgoing>>,
}

impl WizardService {
    pub(crate) fn new(folder: Option<PathBuf>) -> Self {
        Self {
            folder,
            inbox: Inbox::default(),
            outgoing: Mutex::default(),
        }
    }

    /// Queues a request about the site as it is heard; the reply comes by the receiver. May read a file.
    pub(crate) fn request(
        &self,
        request: UserRequest,
        site: SiteMirror,
    ) -> Result<oneshot::Receiver<Reply>, Refusal> {
        let rig = match &request {
            UserRequest::Command(Command::Start(_)) => self.rig_of_site(&site)?,
            UserRequest::Command(_) | UserRequest::Edit(_) => Rig::default(),
        };
        let (reply, receiver) = oneshot::channel();
        let input = Box::new(RequestInput { request, site, rig });
        let queued = self.inbox.put_request((input, reply));
        let busy = |_| Refusal::not_now("too many requests wait; try again in a moment");
        queued.map_err(busy)?;
        Ok(receiver)
    }

    /// The rig in force, completed by the folder's file; the folder's rig while there is no fusion node.
    fn rig_of_site(&self, mirror: &SiteMirror) -> Result<Rig, Refusal> {
        let file = self.folder.as_ref().map(|folder| folder.join("rig.toml"));
        let kept = match file.filter(|file| file.exists()) {
            Some(file) => read_rig(&file).map_err(Refusal::not_now)?,
            None => Rig::default(),
        };
        // It was checked when it was taken in.
        let in_force = mirror.rig().and_then(|rig| Rig::try_from(rig).ok());
        Ok(match in_force {
            Some(rig) => rig.holding_on_to(&kept),
            None => kept,
        })
    }

    /// Queues an image if a wizard collects. An image that finds no room is missed and counted.
    pub(crate) fn put_image(&self, image: impl FnOnce() -> ImageObservation) {
        self.inbox.put_image(image);
    }

    /// What a fusion node offers to be put in force.
    pub(crate) fn put_offer(&self, offer: Offer, proposal: Proposal) {
        self.inbox.put_news(Input::Offer(offer, Box::new(proposal)));
    }

    /// A fusion node is gone.
    pub(crate) fn node_left(&self, node: NodeId) {
        self.inbox.put_news(Input::NodeLeft(node));
    }

    /// A fusion node has answered a change.
    pub(crate) fn put_answer(&self, answer: ConfigAnswer) {
        self.inbox.put_news(Input::Answer(answer));
    }

    /// The next change to be published.
    pub(crate) fn next_outgoing(&self) -> Option<Outgoing> {
        self.outgoing().pop_front()
    }

    /// A change has been published.
    pub(crate) fn note_published(&self) {
        self.inbox.note_published();
    }

    pub(super) fn put_outgoing(&self, outgoing: Outgoing) {
        self.outgoing().push_back(outgoing);
    }

    pub(super) fn folder(&self) -> Option<&PathBuf> {
        self.folder.as_ref()
    }

    pub(super) fn inbox(&self) -> &Inbox {
        &self.inbox
    }

    /// What is under this lock is whole even where somebody panicked.
    fn outgoing(&self) -> MutexGuard<'_, VecDeque<Outgoing>> {
        self.outgoing.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wizard::samples;
    use sextant_site_files::write_rig;
    use sextant_site_model::{PoseSigma, Prior};

    fn asked(service: &WizardService, text: &str) -> Result<(), Refusal> {
        let command = Command::parse(text.as_bytes()).unwrap();
        let queued = service.request(UserRequest::Command(command), samples::mirror());
        queued.map(drop)
    }

    #[test]
    fn a_damaged_rig_file_is_named_at_the_start_and_hinders_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("rig.toml"), "camera = 3").unwrap();
        let service = WizardService::new(Some(folder.path().to_owned()));
        let start = r#"{"do":"start","wizard":"lens","camera":"a",
            "board":{"grid":{"columns":5,"rows":6,"size_m":0.028}}}"#;
        let refused = asked(&service, start).unwrap_err();
        assert!(refused.cause.contains("rig.toml"), "{}", refused.cause);
        asked(&service, r#"{"do":"discard"}"#).unwrap();
    }

    #[test]
    fn a_flood_of_requests_ends_at_the_bound() {
        let service = WizardService::new(None);
        let refused = (0..1000).find_map(|_| asked(&service, r#"{"do":"discard"}"#).err());
        assert!(refused.unwrap().cause.contains("too many requests"));
    }

    #[test]
    fn what_the_folder_knows_of_poses_stays_with_cameras_that_stayed() {
        let folder = tempfile::tempdir().unwrap();
        let prior = Prior::Sigma(PoseSigma {
            position_m: 0.001,
            orientation_rad: 0.002,
        });
        let mut cameras = samples::rig().cameras().to_vec();
        cameras[1].pose_prior = prior;
        let kept = Rig::new(cameras).unwrap();
        write_rig(&folder.path().join("rig.toml"), &kept).unwrap();
        let service = WizardService::new(Some(folder.path().to_owned()));
        let mut mirror = samples::mirror();
        let rig = service.rig_of_site(&mirror).unwrap();
        assert_eq!(rig.cameras()[1].pose_prior, prior);
        let mut cameras = samples::rig().cameras().to_vec();
        cameras[1].world_from_camera = None;
        samples::hear_rig(&mut mirror, &Rig::new(cameras).unwrap());
        let rig = service.rig_of_site(&mirror).unwrap();
        assert_eq!(rig.cameras()[1].pose_prior, Prior::Default);
    }
}
