//! Now and then, while a camera sees no tag: whether it would if tags were read otherwise.

use std::time::{Duration, Instant};

use sextant_apriltag::{Alternative, Image, Options};

/// Time without a tag, and between two looks: each costs several detections.
const PERIOD: Duration = Duration::from_secs(30);

#[derive(Debug)]
pub(super) struct UnreadTags {
    options: Options,
    due: Instant,
}

impl UnreadTags {
    pub(super) fn new(options: Options) -> Self {
        Self {
            options,
            due: Instant::now() + PERIOD,
        }
    }

    /// After an image with so many tags: what the log should say of tags that cannot be read.
    pub(super) fn look(&mut self, image: &Image<'_>, n_tags: usize) -> Option<String> {
        let now = Instant::now();
        let is_due = n_tags == 0 && now >= self.due;
        if n_tags > 0 || is_due {
            self.due = now + PERIOD;
        }
        let found = is_due.then(|| Alternative::find(image, &self.options, &[]))??;
        Some(format!("the image shows {found}: {}", remedy(&found)))
    }
}

fn remedy(found: &Alternative) -> &'static str {
    if found.mirrored {
        "the camera or its driver flips the picture; turn that off, such as with `controls = \
         { horizontal_flip = 0 }` in [source]"
    } else if found.inverted {
        "set `inverted = true` in [detection]"
    } else {
        "set `inverted = false` in [detection]"
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sextant_simulator::{Renderer, Scenario};

    /// The first image of a demo, and its negative.
    fn images() -> ([usize; 2], [Vec<u8>; 2]) {
        let scenario = Scenario::demo(1, 1, 1);
        let size = scenario.cameras[0].resolution.map(|pixels| pixels as usize);
        let mut pixels = vec![0; size[0] * size[1]];
        let mut renderer = Renderer::new(&scenario, 0).unwrap();
        renderer.render(0, &mut pixels).unwrap();
        let negative = pixels.iter().map(|grey| 255 - grey).collect();
        (size, [pixels, negative])
    }

    #[test]
    fn inverted_tags_are_named_once_a_period_without_tags() {
        let ([width, height], [ordinary, inverted]) = images();
        let [ordinary, inverted] =
            [&ordinary, &inverted].map(|pixels| Image::new(pixels, width, height, width).unwrap());
        let mut unread = UnreadTags::new(Options::default());
        assert_eq!(unread.look(&inverted, 0), None);
        unread.due = Instant::now();
        let words = unread.look(&inverted, 0).unwrap();
        assert!(words.contains("inverted tag"), "{words}");
        assert!(
            words.ends_with("set `inverted = true` in [detection]"),
            "{words}"
        );
        assert_eq!(unread.look(&inverted, 0), None);
        unread.due = Instant::now();
        assert_eq!(unread.look(&ordinary, 3), None);
        assert!(unread.due > Instant::now());
    }
}
