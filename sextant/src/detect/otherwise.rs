//! What would have been found, where nothing was: the tags of other families, inverted or mirrored ones.

use super::families::every_family;
use sextant_apriltag::{Alternative, BoardShape, Options, find_chessboard};
use sextant_recordings::read_picture;
use sextant_replay::image_of;
use std::path::{Path, PathBuf};

/// Pictures that are searched for other tags.
const MOST: usize = 5;

/// Pictures in which no tag was found, as long as there is none in any.
#[derive(Debug, Default)]
pub struct NothingFound {
    pictures: Vec<PathBuf>,
    some_found: bool,
}

impl NothingFound {
    /// Takes a picture and its number of tags.
    pub fn add(&mut self, picture: &Path, n_tags: usize) {
        self.some_found |= n_tags > 0;
        if !self.some_found && self.pictures.len() < MOST {
            self.pictures.push(picture.to_owned());
        }
    }

    /// A sentence on the board that the pictures show instead of the one in the board file.
    pub fn other_board(&self, options: &Options) -> Option<String> {
        let (path, found) = match self.alternative(options) {
            Some((path, found)) => (path, format!("{found}; give the file of that board")),
            None => self.chessboard()?,
        };
        Some(format!(
            "no image shows a tag of the board file, but {} shows {found}",
            path.display()
        ))
    }

    /// The first picture with a plain chessboard, and its size in words.
    fn chessboard(&self) -> Option<(&Path, String)> {
        let least = BoardShape {
            columns: 3,
            rows: 3,
        };
        self.pictures.iter().filter(|_| !self.some_found).find_map(|path| {
            let picture = read_picture(path).ok()?;
            let view = find_chessboard(&image_of(&picture).ok()?, least)?;
            let [columns, rows] = view.size;
            let found = format!(
                "a plain chessboard of {columns} x {rows} inner corners or more; give a file that says so"
            );
            Some((path.as_path(), found))
        })
    }

    /// A sentence with the remedy, from the first picture with other tags; `None` where tags were found, or would not
    /// be otherwise either.
    pub fn hint(&self, options: &Options) -> Option<String> {
        let (path, found) = self.alternative(options)?;
        let remedy = remedy(&found, options);
        Some(format!("{} shows {found}: {remedy}", path.display()))
    }

    /// The first picture with other tags, and these.
    fn alternative(&self, options: &Options) -> Option<(&Path, Alternative)> {
        if self.some_found {
            return None;
        }
        let others: Vec<_> = every_family()
            .filter(|family| !options.families.contains(family))
            .collect();
        self.pictures.iter().find_map(|path| {
            let picture = read_picture(path).ok()?;
            let found = Alternative::find(&image_of(&picture).ok()?, options, &others)?;
            Some((path.as_path(), found))
        })
    }
}

/// What to do to find them.
fn remedy(found: &Alternative, options: &Options) -> String {
    if found.mirrored {
        return "the camera or its driver flips the picture, or the tags are seen through a transparent sheet; \
            turn the flip off, no pose can be had from mirrored tags"
            .to_owned();
    }
    let mut words = Vec::new();
    if found.inverted && !options.inverted {
        words.push("--inverted".to_owned());
    }
    if options.inverted && !found.inverted {
        words.push("no --inverted".to_owned());
    }
    for family in &found.families {
        if !options.families.contains(family) {
            words.push(format!("--family {family}"));
        }
    }
    format!("try {}", words.join(" "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use sextant_apriltag::Family;

    fn found(family: Family, inverted: bool, mirrored: bool) -> Alternative {
        Alternative {
            n_tags: 1,
            families: vec![family],
            inverted,
            mirrored,
        }
    }

    #[test]
    fn the_remedy_names_what_differs_from_the_options() {
        let options = Options::default();
        let inverted = found(Family::Tag36h11, true, false);
        assert_eq!(remedy(&inverted, &options), "try --inverted");
        let both = found(Family::Tag25h9, true, false);
        assert_eq!(remedy(&both, &options), "try --inverted --family tag25h9");
        let mirrored = found(Family::Tag36h11, false, true);
        assert!(remedy(&mirrored, &options).contains("turn the flip off"));
    }

    #[test]
    fn nothing_is_said_once_a_tag_was_found() {
        let mut nothing = NothingFound::default();
        nothing.add(Path::new("a.png"), 0);
        nothing.add(Path::new("b.png"), 2);
        assert_eq!(nothing.hint(&Options::default()), None);
    }
}
