//! Files of animations: USD as text, or binary glTF, by their name.

use crate::words;
use anyhow::{Context, anyhow};
use sextant_pose_files::{Animation, LeftOut, glb, write_usda};
use sextant_process::{Exit, Failure, WithExit};
use sextant_site_files::Replacement;
use std::io::{BufWriter, Write};
use std::path::Path;

/// A format of animations.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AnimationFormat {
    /// USD as text.
    Usda,
    /// Binary glTF.
    Glb,
}

impl AnimationFormat {
    /// The format that a file's name says; `None` where it says no animation.
    ///
    /// # Errors
    /// [`Exit::Usage`] for other forms of the formats.
    pub fn named(path: &Path) -> anyhow::Result<Option<Self>> {
        let ending = path.extension().and_then(|ending| ending.to_str());
        let remedy = match ending {
            Some("usda") => return Ok(Some(Self::Usda)),
            Some("glb") => return Ok(Some(Self::Glb)),
            Some("usd" | "usdc" | "usdz") => {
                "USD is written as text: let the name end with .usda; `usdcat` of USD converts it"
            }
            Some("gltf") => "glTF is written as one binary file: let the name end with .glb",
            _ => return Ok(None),
        };
        let cause = anyhow!("{}: {remedy}", path.display());
        Err(Failure::new(Exit::Usage, cause).into())
    }

    /// Writes an animation, whole or not at all.
    ///
    /// # Errors
    /// [`Exit::Input`] for a place that cannot be written and more poses than the format holds.
    pub fn write(self, animation: &Animation, to: &Path) -> anyhow::Result<()> {
        let place = || format!("{}", to.display());
        let replacement = Replacement::begin(to)
            .with_context(|| format!("{}: check the folder", to.display()))
            .exit_with(Exit::Input)?;
        let mut out = BufWriter::new(replacement.file());
        match self {
            Self::Usda => write_usda(animation, &mut out).with_context(place)?,
            Self::Glb => {
                let bytes = glb(animation).with_context(place).exit_with(Exit::Input)?;
                out.write_all(&bytes).with_context(place)?;
            }
        }
        out.flush().with_context(place)?;
        drop(out);
        replacement.commit().with_context(place)?;
        Ok(())
    }
}

/// Says what the animation at `to` lacks.
pub fn say_left_out(left_out: &LeftOut, to: &Path) {
    let place = to.display();
    for (names, cause) in [
        (&left_out.cameras, "they have no pose in the world"),
        (&left_out.objects, "they were never tracked"),
    ] {
        if !names.is_empty() {
            eprintln!("{place}: without {}: {cause}", names.join(", "));
        }
    }
    if left_out.tags > 0 {
        let tags = words::count(left_out.tags, "tag");
        eprintln!("{place}: without {tags}: no place on their object is known");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ending_says_the_format() {
        let named = |name: &str| AnimationFormat::named(Path::new(name));
        assert_eq!(named("a.usda").unwrap(), Some(AnimationFormat::Usda));
        assert_eq!(named("a.glb").unwrap(), Some(AnimationFormat::Glb));
        assert_eq!(named("a.mcap").unwrap(), None);
        for (name, remedy) in [("a.usdc", ".usda"), ("a.usd", ".usda"), ("a.gltf", ".glb")] {
            let error = named(name).unwrap_err().to_string();
            assert!(error.contains(remedy), "{error}");
        }
    }
}
